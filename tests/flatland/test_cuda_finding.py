"""Whether there is a device, and what is said if there is none."""

import itertools
import sys

import numpy as np
import pytest
from host_cupy import CUDARuntimeError, HostCupy, OutOfMemoryError
from on_device import assert_alike, assert_close, both, run_both, stand_in, walled_scene
from scenes import LPV, quiet, scene_of

import propagators
from flatland import InputError, Simulation
from flatland.cuda import find_cuda
from flatland.devices import DEVICES, find_device


def refusal(**arguments):
    with pytest.raises(InputError) as caught:
        Simulation(scene_of(), LPV, **arguments)
    return str(caught.value)


def test_without_cupy(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", None)
    message = refusal(device="cuda")
    assert message.startswith("device = 'cuda': needs CuPy and a CUDA device: CuPy cannot be")
    assert message.endswith("accepted: cpu")
    assert "\n" not in message


def test_without_a_device(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", HostCupy(devices=0))
    assert "there is no CUDA device; accepted: cpu" in refusal(device="cuda")


def test_without_a_driver(monkeypatch):
    """What CuPy's runtime says is passed on."""

    def fails():
        raise CUDARuntimeError("cudaErrorInsufficientDriver: CUDA driver version is insufficient")

    cupy = HostCupy()
    cupy.cuda.runtime.getDeviceCount = fails
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    assert "a CUDA device: cudaErrorInsufficientDriver: CUDA" in refusal(device="cuda")


def test_without_a_compiler_of_kernels(monkeypatch):
    def fails(*, code):
        raise RuntimeError("\n====\nCuPy failed to load libnvrtc.so.13: OSError\n====\n")

    cupy = HostCupy()
    cupy.RawModule = fails
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    assert "a CUDA device: CuPy failed to load libnvrtc.so.13: OSError;" in refusal(device="cuda")


def test_without_room(monkeypatch):
    cupy = stand_in(monkeypatch)
    simulation = quiet(LPV, scene_of(), device="cuda")

    def full(shape, dtype):
        raise OutOfMemoryError

    monkeypatch.setattr(cupy, "zeros", full)
    with pytest.raises(InputError, match="device = 'cuda': has no room for another field of"):
        simulation.run(1)


def test_unknown_devices():
    assert refusal(device="gpu") == "device = 'gpu': is unknown; accepted: cpu, cuda"
    assert find_device("cpu").name == "cpu"
    assert DEVICES == ("cpu", "cuda")


def test_the_name_is_what_its_maker_calls_it(monkeypatch):
    stand_in(monkeypatch)
    assert quiet(LPV, scene_of(), device="cuda").device.name == "stand-in"


def test_the_stand_in_refuses_what_a_device_would_misread(monkeypatch):
    stand_in(monkeypatch)
    device = find_cuda()
    copy = device.vectors._kernels["copy"]
    there = device.upload(np.arange(4.0))
    for arguments in (
        (np.arange(4.0), there, np.int64(4)),  # a host array
        (device.zeros(4, np.float32), there, np.int64(4)),
        (there, device.zeros(4, np.float64), 4),
        (there, device.zeros(4, np.float64), np.int32(4)),
        (there, device.zeros(4, np.float64)),
    ):
        with pytest.raises(TypeError, match="copy"):
            copy((1,), (256,), arguments)
    with pytest.raises(AssertionError):  # more numbers than there are
        copy((1,), (256,), (there, device.zeros(2, np.float64), np.int64(4)))


@pytest.fixture
def real():
    """A device that is really there."""
    try:
        return find_cuda()
    except InputError as error:
        pytest.skip(str(error))


def test_steps_on_a_real_device(real):
    for dimension, clamp, precision in itertools.product(
        (2, 3), (False, True), ("float64", "float32")
    ):
        scene = walled_scene(dimension)
        scheme = propagators.create("lpv", clamp=clamp)
        assert_alike(*run_both(scene, 20, scheme, precision=precision, bands=3))


def test_solutions_on_a_real_device(real):
    for name in ("lpv", "dom8"):
        here, there = both(walled_scene(2), propagators.create(name), bands=3)
        here.solve(1e-11)
        assert there.solve(1e-11).residual <= 1e-11
        assert_close(there.accumulated.values, here.accumulated.values, 1e-8)
