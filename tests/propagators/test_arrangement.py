"""Walls cut where they meet: pieces share their ends, and sides keep their light."""

import numpy as np
import pytest
from analytic_scenes import make_scene, random_scene
from test_analytic_energy import DEGENERATE

from propagators.analytic.geometry import read_geometry
from propagators.transport.arrangement import arrange
from propagators.transport.surface_elements import cut_elements


def arranged(lights=(), walls=(), **more):
    return arrange(read_geometry(make_scene(lights=lights, walls=walls, **more)))


@pytest.mark.parametrize(
    ("walls", "pieces"),
    [
        ([((1, 1), (5, 5)), ((1, 5), (5, 1))], 4),  # cross
        ([((1, 1), (5, 1)), ((3, 1), (3, 5))], 3),  # touch
        ([((1, 1), (5, 1)), ((5, 1), (5, 5))], 2),  # share an end
        ([((1, 1), (5, 1)), ((3, 1), (7, 1))], 3),  # overlap
        ([((1, 1), (5, 1)), ((5, 1), (1, 1))], 1),  # the same
        ([((1, 1), (7, 1)), ((3, 1), (5, 1))], 3),  # one within another
        ([((1, 1), (7, 7)), ((1, 7), (7, 1)), ((4, 1), (4, 7))], 6),  # three through one point
        ([((1, 1), (5, 1)), ((1, 2), (5, 2))], 2),  # apart
    ],
)
def test_pieces_by_hand(walls, pieces):
    assert len(arranged(walls=walls).pieces) == pieces


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(10))
def test_pieces_meet_in_their_ends_only(seed, step):
    made = arrange(read_geometry(random_scene(seed, step=step, walls=15)))
    again = make_scene(lights=(), walls=[(row[:2], row[2:]) for row in made.segments])
    assert len(arrange(read_geometry(again)).pieces) == len(made.pieces)
    assert len(np.unique(np.sort(made.pieces, axis=1), axis=0)) == len(made.pieces)


def test_a_crossing_on_a_grid_line_stays_on_it():
    made = arranged(walls=[((3, 0.1), (3, 7.7)), ((1.1, 2.3), (6.7, 5.9))])
    assert sorted(made.lines[:, 0].tolist()) == [-1, -1, 3, 3]


@pytest.mark.parametrize("name", DEGENERATE)
def test_no_light_gets_lost(name):
    lights, walls = DEGENERATE[name]
    made = arranged(lights, walls)
    flux = 2 * np.einsum("s,skc->c", made.lengths, made.radiance)
    assert flux[0] == pytest.approx(sum(light[2] for light in lights), rel=1e-9)


def test_lights_on_one_another_shine_from_their_own_sides():
    front, back = ((2, 2), (6, 2), 3.0), ((6, 2), (2, 2), 1.0)
    made = arranged([front, back], [((2, 2), (6, 2))], albedo=0.5)
    np.testing.assert_allclose(made.radiance[0, :, 0], [3 / 8, 1 / 8])
    assert made.albedo[0, 0] == 0  # the light lies on top


def test_elements_cut_what_reflects():
    made = cut_elements(arranged([((1, 1), (6, 1), 1.0)], [((1, 3), (6, 3))], albedo=0.5), 0.7)
    assert np.diff(made.first).tolist() == [1, 8]
    np.testing.assert_allclose(made.lengths, [5] + [0.625] * 8)
    np.testing.assert_allclose(made.segments[2], [1.625, 3, 2.25, 3])
