"""Walls left out for whole tiles of targets: exactly those that hide nothing there."""

import numpy as np
import pytest
from numba import njit

import propagators
from flatland import Scene
from propagators.analytic import panels, tiles
from propagators.analytic.geometry import read_geometry
from propagators.analytic.radiosity import bounce
from propagators.analytic.targets import collect_light
from propagators.analytic.tiles import keep_for_box
from propagators.watching import nobody, watched


def cluttered(count, side, seed, length=(3.0, 20.0)):
    """A room of slanted walls that cross each other, lit from one side."""
    generator = np.random.default_rng(seed)
    middles, angles = side * generator.random((count, 2)), np.pi * generator.random(count)
    halves = 0.5 * generator.uniform(*length, count)[:, None]
    halves = halves * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    occluders = [
        {"kind": "segment", "albedo": 0.6, "start": start.tolist(), "end": end.tolist()}
        for start, end in zip(middles - halves, middles + halves)
    ]
    light = {"kind": "area", "start": [0.3 * side, 1.0], "end": [0.6 * side, 1.0], "flux": 5.0}
    return Scene.from_dict(
        {"grid": {"shape": [side, side]}, "light": [light], "occluder": occluders}
    )


@pytest.mark.parametrize(("count", "side", "seed"), [(12, 48, 0), (30, 40, 1), (40, 64, 2)])
def test_tiles_change_nothing(count, side, seed):
    """Against every element by itself, with all walls looked at for every target."""
    geometry = read_geometry(cluttered(count, side, seed))
    bounced = bounce(geometry, 1.0)
    groups = geometry.cell_outlines()[:: 7 if side > 40 else 3]
    found = bounced.arriving(groups, geometry.walls, 3, nobody)
    elements = bounced.elements.segments
    expected = collect_light(groups, elements, bounced.radiosity / 2, geometry.walls, 3)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@njit(error_model="numpy")
def number_kept(box, panel, walls, count, strings, kept):
    """`keep_for_box` has no wrapper for Python."""
    return keep_for_box(box, panel, walls, count, strings, kept)


def test_tiles_leave_walls_out():
    """Or they would be in vain: most of the panels, and most walls of the others."""
    geometry = read_geometry(cluttered(40, 64, 2))
    parts = bounce(geometry, 1.0).elements
    front, counts = panels.front_parts(parts.panels, geometry.walls)
    box, strings, kept = np.array([0.0, 0, 16, 16]), np.empty((2, 4)), np.empty(front.shape[1:])
    left = [
        number_kept(box, panel, walls, count, strings, kept)
        for panel, walls, count in zip(parts.panels, front, counts)
    ]
    assert np.mean(np.array(left) < 0) > 0.5
    seen = np.array(left) >= 0
    assert np.sum(np.array(left)[seen]) < 0.5 * np.sum(counts[seen])


def test_tiles_hold_all_groups_once(rng):
    targets = 100 * rng.random((200, 4, 4))
    order, starts = tiles.tiles_of(targets)
    np.testing.assert_array_equal(np.sort(order), np.arange(200))
    assert starts[0] == 0
    assert starts[-1] == 200
    assert np.all(np.diff(starts) > 0)


def test_long_answers_tell_how_far_they_are():
    shares = []
    with watched(shares.append):
        propagators.create("analytic").solve(cluttered(6, 40, 3), 2)
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert np.all(np.diff(shares) >= 0)
    assert len(shares) > 5
