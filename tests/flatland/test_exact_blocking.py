"""Exact blocking: shares of beams, symmetry."""

import numpy as np
import pytest
from links import ALL, AXIAL, GRID, random_walls, transmittance, walls
from space import moved

from flatland.blocking import exact_transmittance
from flatland.errors import InputError
from flatland.grid import Grid

EAST, NORTH_EAST, NORTH, NORTH_WEST, WEST, SOUTH_WEST, SOUTH, SOUTH_EAST = range(8)


# -- what is cut ----------------------------------------------------------------------------------


def test_no_walls_give_none():
    assert exact_transmittance(GRID, [], ALL) is None


@pytest.mark.parametrize(
    "wall",
    [
        pytest.param((30, 0, 31, 4), id="far away"),
        pytest.param((2, 9, 7, 9), id="above"),
        pytest.param((2.3, 1.2, 2.3, 1.2), id="without length"),
        pytest.param((2, 1.5, 2, 1.5), id="without length, on a centre ray"),
    ],
)
def test_walls_that_meet_no_link_give_none(wall):
    assert exact_transmittance(GRID, walls(wall), ALL) is None


def test_wall_along_axial_links_gives_none_without_links_across_it():
    assert exact_transmittance(GRID, walls((1, 2.3, 4, 2.3)), [(1, 0), (-1, 0)]) is None


def test_wall_on_a_grid_line_shuts_the_links_across_it_and_no_others():
    expected = np.ones((4, *GRID.shape))
    expected[0, 2, 1:4] = expected[2, 3, 1:4] = 0
    np.testing.assert_array_equal(transmittance((3, 1, 3, 4), offsets=AXIAL), expected)


@pytest.mark.parametrize("length", [0.0625, 0.3, 0.5])
def test_partly_covered_link_passes_the_rest(length):
    tau = transmittance((3, 1, 3, 1 + length))
    assert tau[EAST, 2, 1] == pytest.approx(1 - length, abs=1e-15)


def test_link_covered_past_its_centre_is_shut():
    assert transmittance((3, 1, 3, 1.51))[EAST, 2, 1] == 0


def test_diagonal_beam_is_as_wide_as_the_cell_looks():
    """A wall of length 0.4 across d = (1, 1), on one side of the beam of width √2."""
    step = 0.4 / np.sqrt(2)
    tau = transmittance((3.1, 1.9, 3.1 + step, 1.9 - step))
    assert tau[NORTH_EAST, 2, 1] == pytest.approx(1 - 0.4 / np.sqrt(2))


def test_wall_that_ends_on_a_corner_halves_the_diagonals_there():
    tau = transmittance((3, -1, 3, 2))
    assert tau[NORTH_EAST, 2, 1] == tau[SOUTH_EAST, 2, 2] == 0.5
    assert tau[NORTH_EAST, 2, 0] == 0
    assert tau[NORTH_EAST, 2, 2] == 1


def test_walls_that_meet_on_a_centre_ray_shut_it():
    tau = transmittance((3, 1.2, 3.1, 1.5), (3.1, 1.5, 3, 1.9))
    assert tau[EAST, 2, 1] == 0


def test_corner_that_touches_a_centre_ray_from_one_side_does_not_shut_it():
    tau = transmittance((3, 1.2, 3.1, 1.5), (3.1, 1.5, 3.2, 1.2))
    assert tau[EAST, 2, 1] == pytest.approx(0.7)


def test_wall_through_a_centre_shuts_all_links_but_those_along_it():
    tau = transmittance((1, 2.5, 5, 2.5))[:, 3, 2]
    np.testing.assert_array_equal(tau, [1, 0, 0, 0, 1, 0, 0, 0])


def test_slanted_wall_along_a_centre_ray_is_no_obstacle_to_it():
    assert transmittance((1.1, 1.1, 3.9, 3.9))[NORTH_EAST, 2, 2] == 1


def test_wall_along_a_centre_ray_shuts_it_where_another_leaves():
    """A box through centres: light that runs along its side cannot turn out at a corner."""
    tau = transmittance((1, 2.5, 2.9, 2.5), (2.9, 2.5, 2.9, 4))
    assert tau[EAST, 2, 2] == 0


def test_links_out_of_the_grid_are_links():
    tau = transmittance((6, -1, 6, 6), (-0.5, 1, -0.5, 1.25))
    assert np.all(tau[EAST, 5] == 0)
    assert tau[WEST, 0, 1] == 0.75


def test_parts_outside_the_grid_change_nothing():
    near, far = (
        transmittance((2.5, 1.3, 8, 1.85)),
        transmittance((2.5, 1.3, 1e12 + 2.5, 1e11 + 1.3)),
    )
    np.testing.assert_allclose(near, far, atol=1e-12)


def test_rounding_in_coordinates_changes_nothing():
    noise = 1e-12 * np.random.default_rng(0).normal(size=(3, 4))
    ends = np.array([(3, 1, 3, 4), (1, 2.5, 5, 2.5), (0.5, 0.5, 4.5, 4.5)])
    np.testing.assert_allclose(transmittance(*(ends + noise)), transmittance(*ends), atol=1e-11)


def test_overlapping_walls_count_once():
    tau = transmittance((3, 1, 3, 1.3), (3.2, 1.1, 3.2, 1.4), (2.9, 1, 2.9, 1.2), (3, 1, 3, 1.3))
    assert tau[EAST, 2, 1] == pytest.approx(0.6)


def test_a_free_end_reaches_an_eighth_of_a_cell_too_far_on_average():
    """The price of the centre-ray rule, averaged over where in its cell a wall ends."""
    count = 200
    ends = [(3, j, 3, j + (j + 0.5) / count) for j in range(count)]
    tau = transmittance(*ends, grid=Grid((6, count)), offsets=[(1, 0)])
    assert 0.5 - tau[0, 2].mean() == pytest.approx(0.125, abs=0.003)


# -- against many parallel rays -------------------------------------------------------------------


def crossings(origins, along, ends):
    """Whether rays origins (N, 2) + t along (2,), 0 ≤ t ≤ 1, meet each wall (S, 4): (N, S)."""
    start, wall = ends[:, :2], ends[:, 2:] - ends[:, :2]
    gap = start - origins[:, None]
    scale = along[0] * wall[:, 1] - along[1] * wall[:, 0]
    t = (gap[..., 0] * wall[:, 1] - gap[..., 1] * wall[:, 0]) / scale
    u = (gap[..., 0] * along[1] - gap[..., 1] * along[0]) / scale
    return (t >= 0) & (t <= 1) & (u >= 0) & (u <= 1)


def share_of_rays(ends, cell, step, count=1000):
    """τ of one link by counting rays, with the centre-ray rule."""
    center, across = np.add(cell, 0.5), np.array([-step[1], step[0]])
    width = np.abs(step).sum() / (step @ step)
    places = ((np.arange(count) + 0.5) / count - 0.5)[:, None] * width * across
    if crossings(center[None], step, ends).any():
        return 0.0
    return float(np.mean(~crossings(center + places, step, ends).any(axis=1)))


@pytest.mark.parametrize(("seed", "count"), [(1, 1), (2, 3), (3, 12)])
def test_shares_equal_those_of_many_parallel_rays(seed, count):
    ends, rays = random_walls(seed, count), 1000
    counted = [
        [[share_of_rays(ends, (i, j), step, rays) for j in range(5)] for i in range(6)]
        for step in ALL
    ]
    # A ray more or less at each of the two ends of every wall.
    np.testing.assert_allclose(transmittance(*ends), counted, rtol=0, atol=4 / rays)


# -- symmetry -------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_both_ways_through_a_link_are_alike(seed):
    tau = transmittance(*random_walls(seed, 12))
    for index, step in enumerate(ALL):
        back = tau[(index + 4) % 8]
        np.testing.assert_array_equal(moved(tau[index], -step), moved(back, step))


@pytest.mark.parametrize("seed", range(3))
def test_mirrored_scene_has_mirrored_shares(seed):
    ends = random_walls(seed, 12)
    mirrored = ends * (-1, 1, -1, 1) + (6, 0, 6, 0)
    expected = transmittance(*ends, offsets=ALL * (-1, 1))[:, ::-1]
    np.testing.assert_allclose(transmittance(*mirrored), expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_turned_scene_has_turned_shares(seed):
    """A quarter turn: (x, y) -> (5 − y, x)."""
    ends = random_walls(seed, 12)
    turned = ends[:, [1, 0, 3, 2]] * (-1, 1, -1, 1) + (5, 0, 5, 0)
    actual = transmittance(*turned, grid=Grid((5, 6)), offsets=np.roll(ALL, -2, axis=0))
    expected = np.rot90(transmittance(*ends), axes=(1, 2))
    np.testing.assert_allclose(actual, expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_order_and_sense_of_walls_change_nothing(seed):
    ends = random_walls(seed, 12)
    other = ends[::-1, [2, 3, 0, 1]]
    np.testing.assert_allclose(transmittance(*other), transmittance(*ends), atol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_splitting_walls_changes_nothing(seed):
    ends = random_walls(seed, 12)
    part = np.random.default_rng(seed).random((12, 1))
    cuts = ends[:, :2] + part * (ends[:, 2:] - ends[:, :2])
    pieces = np.concatenate([np.hstack([ends[:, :2], cuts]), np.hstack([cuts, ends[:, 2:]])])
    np.testing.assert_allclose(transmittance(*pieces), transmittance(*ends), atol=1e-12)


def test_splitting_at_the_centre_ray_changes_nothing():
    whole = transmittance((1, 0.3, 5, 4.7))
    pieces = transmittance((1, 0.3, 3, 2.5), (3, 2.5, 5, 4.7))
    np.testing.assert_allclose(pieces, whole, atol=1e-12)


def test_spacing_and_origin_only_say_where_cells_are():
    ends = random_walls(5, 12)
    grid = Grid((6, 5), spacing=0.37, origin=(-4.1, 90.3))
    placed = grid.to_world(ends.reshape(-1, 2)).reshape(-1, 4)
    np.testing.assert_allclose(transmittance(*placed, grid=grid), transmittance(*ends), atol=1e-11)


def test_every_offset_is_on_its_own():
    ends = random_walls(6, 12)
    np.testing.assert_array_equal(
        transmittance(*ends, offsets=ALL[[5, 2]]), transmittance(*ends)[[5, 2]]
    )


# -- what is refused ------------------------------------------------------------------------------


def test_segments_in_a_grid_in_3d_are_refused():
    with pytest.raises(InputError, match="walls"):
        exact_transmittance(Grid((2, 2, 2)), walls((0, 0, 1, 1)), [(1, 0, 0)])


@pytest.mark.parametrize(
    "offsets", [[], (1, 0), [(0, 0)], [(1, 2)], [(1, 0), (0.5, 0)], [(1, 0, 0)]]
)
def test_offsets_to_other_than_neighbours_are_refused(offsets):
    with pytest.raises(InputError, match="offsets"):
        exact_transmittance(GRID, walls((0, 0, 1, 1)), offsets)


def test_walls_without_finite_ends_are_refused():
    with pytest.raises(InputError, match="segments"):
        exact_transmittance(GRID, walls((0, 0, np.inf, 1)), ALL)
