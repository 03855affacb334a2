"""Result files: complete or not there, and they say how to do it again."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import propagators
from flatland import Scene, Simulation
from flatland.errors import ResultFileError
from flatland.results import load_dataset, result_dataset, save_dataset, write_atomically
from flatland.scene import parse_scene
from studies.running import Method, run_method


@pytest.fixture
def scene():
    light = {"kind": "cell", "cell": [1, 2], "flux": [1.0, 2.0, 3.0]}
    return Scene.from_dict({"grid": {"shape": [4, 5], "spacing": 0.5}, "light": [light]})


def _result(scene):
    method = Method(propagators.create("lpv"), bands=2, iterations=3)
    run = run_method(scene, method)
    return run, result_dataset(scene, {"accumulated": run.accumulated}, method.as_dict())


def test_a_file_gives_back_the_field_its_axes_and_its_scene(tmp_path, scene):
    run, data = _result(scene)
    read = load_dataset(save_dataset(data, tmp_path / "a.nc"))
    assert read["accumulated"].dims == ("colour", "coefficient", "x", "y")
    np.testing.assert_array_equal(read["accumulated"].values, run.accumulated.values)
    np.testing.assert_allclose(read["y"].values, [0.25, 0.75, 1.25, 1.75, 2.25])
    assert parse_scene(read.attrs["scene"]) == scene


def test_the_stored_method_computes_the_same_again(tmp_path, scene):
    run, data = _result(scene)
    read = load_dataset(save_dataset(data, tmp_path / "a.nc"))
    method = json.loads(read.attrs["method"])
    again = Simulation(
        parse_scene(read.attrs["scene"]),
        propagators.create(method["propagator"], **method["options"]),
        bands=method["bands"],
        precision=method["precision"],
    )
    again.run(method["iterations"])
    np.testing.assert_array_equal(again.accumulated.values, run.accumulated.values)


def test_a_disk_that_is_full_ends_a_write_with_a_message(tmp_path, capfd):
    """A true refusal of the system, at any place in the file: no noise, no crash, no half file."""
    resource = pytest.importorskip("resource")
    data = xr.Dataset({"a": ("x", np.arange(1000.0)), "b": ("x", np.array(["text"] * 1000))})
    size = save_dataset(data, tmp_path / "whole.nc").stat().st_size
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    for limit in (0, 100, 4096, size - 1):
        try:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
            with pytest.raises(ResultFileError, match=r"a\.nc: cannot be written: File too large"):
                save_dataset(data, tmp_path / "a.nc")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert [path.name for path in tmp_path.iterdir()] == ["whole.nc"]
    assert capfd.readouterr() == ("", "")


def test_a_failed_write_keeps_the_old_file_and_leaves_no_other(tmp_path):
    target = tmp_path / "a.nc"
    target.write_text("old")

    def fail(place):
        place.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(ResultFileError, match=r"a\.nc: cannot be written: No space left"):
        write_atomically(target, fail)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_an_interrupt_while_writing_leaves_no_file(tmp_path):
    def interrupt(place):
        place.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "a.nc", interrupt)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [b"", b"not netCDF", bytes(range(256)) * 40])
def test_a_file_that_is_no_result_is_named(tmp_path, content):
    path = tmp_path / "broken.nc"
    path.write_bytes(content)
    with pytest.raises(ResultFileError, match=r"broken\.nc"):
        load_dataset(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ResultFileError, match=r"nowhere\.nc"):
        load_dataset(tmp_path / "nowhere.nc")
