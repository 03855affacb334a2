"""Runs on a CUDA device, or on its stand-in, beside the same runs on the processor."""

import sys

import numpy as np
import pytest
from host_cupy import COMPILER, Array, HostCupy
from scenes import LIGHTS, SHAPE, quiet

from flatland.scene import Scene

#: Sums of the same numbers in another order, relative to the largest.
ROUNDING = {"float64": 1e-13, "float32": 2e-6}
WALLS = [
    {"kind": "segment", "start": [2.0, 5.3], "end": [7.0, 4.8], "albedo": 0.6},
    {"kind": "segment", "start": [6.0, 1.0], "end": [6.5, 3.8], "albedo": 0.2},
]
WALLS_3D = [
    {"kind": "box", "min": [2.0, 1.5, 1.0], "max": [4.0, 3.0, 3.2], "albedo": 0.7},
]
LIGHTS_3D = [
    {"kind": "cell", "cell": [1, 2, 3], "direction": [1.0, 0.4, 0.2], "flux": 2.0},
    {"kind": "cell", "cell": [4, 0, 1], "flux": 1.0},
]
SHAPE_3D = (6, 5, 4)


def stand_in(monkeypatch, **arguments):
    """Lets the engine find a stand-in for CuPy; skips where no compiler could make its kernels."""
    if COMPILER is None:
        pytest.skip("no C compiler to make kernels with")
    cupy = HostCupy(**arguments)
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    return cupy


def space_scene(walls=()):
    """A scene in 3D like that of `scenes`."""
    return Scene.from_dict(
        {"grid": {"shape": SHAPE_3D}, "light": LIGHTS_3D, "occluder": list(walls)}
    )


def walled_scene(dimension, shape=SHAPE):
    """A scene with walls that send light back."""
    if dimension == 3:
        return space_scene(WALLS_3D)
    return Scene.from_dict({"grid": {"shape": shape}, "light": LIGHTS, "occluder": WALLS})


def both(scene, propagator, **arguments):
    """The same simulation on the processor and on the device."""
    return [quiet(propagator, scene, device=device, **arguments) for device in ("cpu", "cuda")]


def run_both(scene, steps, propagator, **arguments):
    """Both after some steps."""
    pair = both(scene, propagator, **arguments)
    for simulation in pair:
        simulation.run(steps)
    return pair


def assert_alike(here, there, tolerance=None):
    """The same light on every level, and the same books, to rounding."""
    tolerance = tolerance or ROUNDING[here.precision]
    assert here.iteration == there.iteration
    for number in range(here.levels):
        first, second = here.level(number), there.level(number)
        for name in ("source", "target", "accumulated"):
            wanted, found = getattr(first, name).values, getattr(second, name).values
            assert found.dtype == wanted.dtype
            assert_close(found, wanted, tolerance)
        assert_same_books(first.ledger, second.ledger, 40 * tolerance)


def assert_same_books(here, there, tolerance):
    """Entries as near as the largest of them allows."""
    scale = max(np.abs(value).max() for value in here.as_dict().values())
    for name, wanted in here.as_dict().items():
        np.testing.assert_allclose(there.as_dict()[name], wanted, rtol=0, atol=tolerance * scale)


def assert_close(found, wanted, tolerance):
    """As near as the largest of all numbers allows."""
    size = np.abs(wanted).max(initial=0.0)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * size)


class Downloads:
    """Counts arrays of at least a given size that come back from the stand-in."""

    def __init__(self, monkeypatch, least):
        self.count = 0
        get = Array.get

        def counted(array, out=None):
            self.count += array.size >= least
            return get(array, out)

        monkeypatch.setattr(Array, "get", counted)
