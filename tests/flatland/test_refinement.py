"""The same scene on finer grids: nothing but the cells changes."""

from __future__ import annotations

import numpy as np
import pytest

from flatland import Scene, load_scene
from flatland.errors import InputError
from flatland.harmonics import basis_for
from flatland.injection import inject
from flatland.scene import refined

WALL = {"kind": "wall", "side": "left", "flux": 3.0, "first": 1, "last": 4}
CELL = {"kind": "cell", "cell": [2, 3], "direction": [1.0, 0.4], "flux": 2.0}
AREA = {"kind": "area", "start": [2.1, 0.0], "end": [3.7, 0.9], "flux": 1.5}


def scene_of(*lights):
    grid = {"shape": [8, 7], "spacing": 0.5, "origin": [1.0, -2.0]}
    return Scene.from_dict({"grid": grid, "light": list(lights)})


@pytest.mark.parametrize("name", ["shelf", "corridor", "clutter", "cornell-2d"])
@pytest.mark.parametrize("factor", [2, 3])
def test_everything_in_metres_stays(name, factor):
    scene, finer = load_scene(name), refined(load_scene(name), factor)
    assert finer.grid.shape == tuple(factor * cells for cells in scene.grid.shape)
    np.testing.assert_allclose(finer.grid.upper, scene.grid.upper, rtol=1e-15)
    assert finer.lights == scene.lights
    assert finer.occluders == scene.occluders


@pytest.mark.parametrize("light", [CELL, WALL, AREA])
def test_the_flux_stays(light):
    scene = scene_of(light)
    fluxes = [inject(refined(scene, factor), basis_for(2, 2)).total_flux() for factor in (1, 3, 5)]
    np.testing.assert_allclose(fluxes, fluxes[0], rtol=1e-13)


def test_a_lit_cell_stays_the_point_it_is():
    scene = scene_of(CELL)
    (before,), (after,) = scene.sources(), refined(scene, 5).sources()
    np.testing.assert_allclose(after.position, before.position, rtol=1e-15)


def test_a_lit_wall_stays_where_it_is():
    scene = scene_of(WALL)
    heights = [
        np.array([source.position[1] for source in refined(scene, factor).sources()])
        for factor in (1, 4)
    ]
    assert len(heights[1]) == 4 * len(heights[0])
    np.testing.assert_allclose(heights[0], heights[1].reshape(-1, 4).mean(axis=1), rtol=1e-14)


@pytest.mark.parametrize(
    ("light", "factor", "words"),
    [
        (CELL, 2, ["resolution = 2", "odd", "'cell'"]),
        (AREA, 0, ["resolution = 0", "at least 1"]),
        (AREA, 1.5, ["resolution = 1.5", "whole"]),
    ],
)
def test_what_cannot_be_refined_is_refused(light, factor, words):
    with pytest.raises(InputError) as caught:
        refined(scene_of(light), factor)
    for word in words:
        assert word in str(caught.value)


def test_a_file_of_coefficients_is_refused(tmp_path):
    np.save(tmp_path / "a.npy", np.ones((1, 4, 4)))
    tables = {"grid": {"shape": [4, 4]}, "light": [{"kind": "file", "file": "a.npy"}]}
    scene = Scene.from_dict(tables, directory=tmp_path)
    assert refined(scene, 1) is scene
    with pytest.raises(InputError, match="'file'"):
        refined(scene, 3)
