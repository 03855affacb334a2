"""Comparisons with an exact answer in 3D, which these tests make up: a field of few bands."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import propagators
from flatland import InputError, Scene, SphericalHarmonics
from flatland.field import Field
from flatland.results import load_dataset
from studies.commands.compare import command
from studies.comparison import compare
from studies.figures.comparison import LARGEST_FOR_LOBES, comparison_data, draw_comparison
from studies.figures.slices import Slice
from studies.reference import Reference, even_directions
from studies.running import Method
from studies.style import figure_style

BANDS = 3
SHAPE = (5, 4, 6)


class MadeUp:
    """An "exact" answer of three bands: an uneven light in every cell."""

    def __init__(self, **options):
        assert set(options) <= {"bounces"}

    def solve(self, scene, bands):
        basis = SphericalHarmonics(BANDS)
        colours = (scene.colours,) * bool(scene.colours)
        generator = np.random.default_rng(8)
        values = generator.uniform(-0.2, 0.2, (*colours, basis.size, *scene.grid.shape))
        values[(..., 0, *[slice(None)] * 3)] = 2.0
        return Field(scene.grid, basis, values).with_bands(bands)

    def intensity(self, scene, directions):
        return self.solve(scene, BANDS).evaluate(directions)


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    monkeypatch.setattr("studies.reference.create", lambda name, **options: MadeUp(**options))


def scene_of(shape=SHAPE, flux=2.0):
    quad = [[1, 0, 0], [1, 0, 6], [1, 3, 6], [1, 3, 0]]
    light = {"kind": "area", "vertices": np.add(quad, [1, 1, 0]), "flux": flux}
    tables = {"title": "Test", "grid": {"shape": shape}, "light": [light]}
    return Scene.from_dict({**tables, "occluder": [{"kind": "quad", "vertices": quad}]})


def comparison_of(scene, bands=(2,)):
    lpv, dom = propagators.create("lpv"), propagators.create("dom6")
    return compare(
        scene, [Method(each, n, 3, blocking="none") for n in bands for each in (lpv, dom)]
    )


@pytest.mark.parametrize(("dimension", "count"), [(2, 256), (3, 256), (3, 1024)])
def test_directions_are_even(dimension, count):
    """They integrate harmonics, and no two are much nearer than their angle allows."""
    directions = even_directions(dimension, count)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, rtol=1e-12)
    second = directions.T @ directions / count
    np.testing.assert_allclose(second, np.eye(dimension) / dimension, atol=1e-4)
    np.testing.assert_allclose(directions.mean(axis=0), 0, atol=3e-4)
    if dimension == 3:
        near = np.sort(directions @ directions.T, axis=1)[:, -2]
        spacing = np.sqrt(4 * np.pi / count)
        assert np.arccos(near).min() > 0.75 * spacing


def test_a_lattice_on_the_sphere_misses_jumps_by_less_than_chance():
    """Share of the sphere in random caps: errors fall like count^(-3/4), not count^(-1/2)."""
    generator = np.random.default_rng(2)
    axes = generator.normal(size=(300, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    heights = generator.uniform(-1, 1, 300)
    counts, errors = np.array([128, 512, 2048, 8192]), []
    for count in counts:
        inside = even_directions(3, int(count)) @ axes.T > heights
        errors.append(np.sqrt(np.mean((inside.mean(axis=0) - (1 - heights) / 2) ** 2)))
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -0.85 < slope < -0.68, f"order {-slope:.2f}, errors {errors}"


def test_a_field_is_measured_against_all_directions():
    """The made-up answer itself has no error, and a field of fewer bands misses the rest."""
    scene = scene_of()
    comparison = comparison_of(scene, bands=(2, 4))
    exact = MadeUp().solve(scene, BANDS)
    size = np.linalg.norm(exact.values)
    rest = np.linalg.norm(exact.values[4:]) / size
    for run, errors in zip(comparison.runs, comparison.errors):
        assert errors["floor"] == pytest.approx(
            rest if run.method.bands == 2 else 0, rel=2e-3, abs=1e-12
        )
        missing = exact.with_bands(4).values - run.accumulated.with_bands(4).values
        assert errors["angular"] == pytest.approx(np.linalg.norm(missing) / size, rel=2e-3)
        assert errors["angular"] > errors["floor"]


def test_an_intensity_too_large_for_memory_is_refused(monkeypatch):
    monkeypatch.setattr("flatland.memory.available_memory", lambda: 2**20)
    with pytest.raises(InputError, match="of memory"):
        _ = Reference(scene_of()).intensity


@pytest.mark.parametrize("layer", [Slice(0, 3), Slice(1, 1), Slice(2, 5)])
@pytest.mark.parametrize("flux", [2.0, [1.0, 2.0]])
def test_data_of_a_slice_are_the_spherical_function_in_its_plane(layer, flux):
    scene = scene_of(flux=flux)
    comparison = comparison_of(scene)
    data = comparison_data(comparison, layer)
    across, up = (axis for axis in range(3) if axis != layer.axis)
    assert data["exact"].dims == ("direction", "xyz"[across], "xyz"[up])
    assert data["exact"].attrs["units"] == "W/sr"
    directions = np.zeros((data.sizes["direction"], 3))
    directions[:, across] = np.cos(data["direction"])
    directions[:, up] = np.sin(data["direction"])

    def expected(field):
        light = field.evaluate(directions)
        light = light.sum(axis=0) if scene.colours else light
        return np.take(light, layer.cell, axis=1 + layer.axis)

    exact = MadeUp().solve(scene, BANDS)
    np.testing.assert_allclose(data["exact"], expected(exact), atol=1e-12)
    run = comparison.runs[0]
    found = data["intensity"].sel(scheme="lpv", bands=2)
    np.testing.assert_allclose(found, expected(run.accumulated), atol=1e-12)
    total = run.accumulated.scalar_flux()
    total = total.sum(axis=0) if scene.colours else total
    np.testing.assert_allclose(
        data["flux"].sel(scheme="lpv", bands=2), np.take(total, layer.cell, axis=layer.axis)
    )


@pytest.mark.parametrize("shape", [SHAPE, (LARGEST_FOR_LOBES + 3, 5, 6)])
def test_a_slice_is_drawn_with_its_place_and_its_walls(shape):
    data = comparison_data(comparison_of(scene_of(shape)), Slice(1, 1))
    with figure_style():
        figure = draw_comparison(data)
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()[-5:]) == ("x [m]", "z [m]")
    titles = [axes.get_title(), figure.get_suptitle()]
    assert any("y = 1.5 m" in title for title in titles)
    lines = [each.get_segments() for each in axes.collections if hasattr(each, "get_segments")]
    assert any(
        np.shape(each) == (1, 2, 2) and np.ptp(each, axis=1).tolist() == [[0, 6]] for each in lines
    )


def test_compare_takes_a_slice(tmp_path):
    (tmp_path / "a.toml").write_text(
        "[grid]\nshape = [4, 5, 3]\n[[light]]\nkind = 'cell'\ncell = [1, 1, 1]\nflux = 1\n"
    )
    arguments = [str(tmp_path / "a.toml"), "--bands", "2", "--iterations", "2"]
    picture = str(tmp_path / "a.png")
    result = CliRunner().invoke(command, [*arguments, "-o", picture, "--slice", "x=3", "--json"])
    assert result.exit_code == 0, result.output
    names = [run["method"]["propagator"] for run in json.loads(result.stdout)["runs"]]
    assert names == ["lpv", "dom6", "dom26"]
    data = load_dataset(tmp_path / "a.nc")
    assert dict(data.sizes) | {"y": 5, "z": 3} == dict(data.sizes)
    assert data.attrs["place"] == "x = 3.5 m"


@pytest.mark.parametrize(
    ("scene", "arguments", "words"),
    [
        ("fig5-one-light-3d", ["--slice", "z=1"], "needs --output"),
        ("fig5-one-light-3d", ["-o", "a.png", "--slice", "z=17"], "at most 16"),
        ("fig5-one-light", ["-o", "a.png", "--slice", "z=1"], "needs a scene in 3D"),
    ],
)
def test_a_slice_that_cannot_be_is_refused_before_the_run(scene, arguments, words):
    error = CliRunner().invoke(command, [scene, *arguments]).exception
    assert isinstance(error, InputError)
    assert words in str(error)
