"""Exact blocking in 3D: shares of beams, agreement with 2D and with rays."""

import numpy as np
import pytest
from links3d import (
    GRID,
    L_PARTS,
    L_SHAPE,
    ROUNDING,
    across_x,
    along,
    laid,
    random_triangles,
    transmittance,
)
from space import NEIGHBOURS, facets, triangles_of

from flatland.blocking import exact_transmittance
from flatland.errors import InputError
from flatland.grid import Grid
from flatland.sources import Facet, Segment

# -- what is cut ----------------------------------------------------------------------------------


def test_no_walls_give_none():
    assert exact_transmittance(GRID, [], NEIGHBOURS) is None


@pytest.mark.parametrize(
    "wall",
    [
        pytest.param(across_x(40, (0, 5), (0, 4)), id="far away"),
        pytest.param([(1, 1.2, 2), (2, 1.2, 2), (3, 1.2, 2)], id="without area"),
        pytest.param([(1, 1.5, 1.5), (2, 1.5, 1.5), (4, 1.5, 1.5)], id="line on a centre ray"),
        pytest.param([(2.3, 1.2, 2)] * 3, id="a point"),
    ],
)
def test_walls_that_meet_no_link_give_none(wall):
    assert exact_transmittance(GRID, facets(wall), NEIGHBOURS) is None


def test_wall_along_axial_links_gives_none_without_links_across_it():
    wall = across_x(2.3, (1, 4), (1, 3))
    assert exact_transmittance(GRID, facets(wall), [(0, 1, 0), (0, 0, -1)]) is None


def test_wall_on_a_grid_plane_shuts_the_links_across_it_and_no_others():
    tau = transmittance(across_x(3, (-1, 6), (-1, 5)))
    crossing = np.zeros(tau.shape, bool)
    crossing[NEIGHBOURS[:, 0] == 1, 2] = crossing[NEIGHBOURS[:, 0] == -1, 3] = True
    np.testing.assert_array_equal(tau[crossing], 0)
    # What of a diagonal beam reaches beyond its two cells would meet the wall from behind.
    np.testing.assert_array_equal(tau[~crossing], 1)


@pytest.mark.parametrize("y", [0.0625, 0.3, 0.5])
@pytest.mark.parametrize("z", [0.25, 1.0])
def test_partly_covered_axial_link_passes_the_rest(y, z):
    tau = transmittance(across_x(3, (1, 1 + y), (2, 2 + z)))
    assert tau[along(1, 0, 0), 2, 1, 2] == pytest.approx(1 - y * z, abs=ROUNDING)


def test_link_covered_past_its_centre_is_shut():
    wall = across_x(3, (1.49, 1.51), (2.49, 2.51))
    assert transmittance(wall)[along(1, 0, 0), 2, 1, 2] == 0


def test_wall_that_ends_on_an_edge_of_a_cell_halves_the_diagonals_there():
    tau = transmittance(across_x(3, (-1, 2), (-1, 5)))
    for z in (-1, 0, 1):
        assert tau[along(1, 1, z), 2, 1, 2] == pytest.approx(0.5, abs=ROUNDING)
        assert tau[along(1, -1, z), 2, 2, 2] == pytest.approx(0.5, abs=ROUNDING)


def test_wall_that_ends_in_a_corner_of_a_cell_cuts_a_third_or_a_sixth_of_the_hexagons_there():
    """Its two edges are seen along the diagonals at 120 or 60 degrees."""
    tau = transmittance(across_x(3, (-1, 2), (-1, 2)))
    assert tau[along(1, 1, 1), 2, 1, 1] == pytest.approx(2 / 3, abs=ROUNDING)
    assert tau[along(1, 1, -1), 2, 1, 2] == pytest.approx(5 / 6, abs=ROUNDING)


def test_small_square_across_a_diagonal_covers_its_part_of_the_hexagon():
    """Across (1, 1, 1), area 0.04 of √3, beside the centre ray."""
    u, v = np.array([1, -1, 0]) / np.sqrt(2), np.array([1, 1, -2]) / np.sqrt(6)
    square = [
        (3, 2, 2) + a * u + b * v for a, b in ((0.1, 0.1), (0.3, 0.1), (0.3, 0.3), (0.1, 0.3))
    ]
    tau = transmittance(square)
    assert tau[along(1, 1, 1), 2, 1, 1] == pytest.approx(1 - 0.04 / np.sqrt(3), abs=ROUNDING)


def test_wall_through_a_centre_shuts_all_links_but_those_along_it():
    tau = transmittance([(1, 2.5, 0), (5, 2.5, 0), (5, 2.5, 4), (1, 2.5, 4)])[:, 3, 2, 2]
    np.testing.assert_array_equal(tau, NEIGHBOURS[:, 1] == 0)


def test_links_out_of_the_grid_are_links():
    tau = transmittance(across_x(6, (-1, 6), (-1, 5)), across_x(-0.5, (1, 1.25), (2, 3)))
    assert np.all(tau[along(1, 0, 0), 5] == 0)
    assert tau[along(-1, 0, 0), 0, 1, 2] == pytest.approx(0.75, abs=ROUNDING)


def test_overlapping_walls_count_once():
    tau = transmittance(
        across_x(3, (1, 1.3), (2, 3)),
        across_x(3.2, (1.1, 1.4), (2, 3)),
        across_x(2.9, (1, 1.2), (2, 2.5)),
        across_x(3, (1, 1.3), (2, 3)),
    )
    assert tau[along(1, 0, 0), 2, 1, 2] == pytest.approx(0.6, abs=ROUNDING)


def test_a_wall_given_twice_or_from_behind_is_one_wall():
    walls = random_triangles(3, 6)
    twice = [*walls, *(wall[::-1] for wall in walls)]
    np.testing.assert_allclose(transmittance(*twice), transmittance(*walls), atol=ROUNDING)


@pytest.mark.parametrize("reach", [30.0, 1e6])
def test_parts_outside_the_grid_change_nothing(reach):
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    near, far = (
        np.insert(size * square, 2, 1.3 + 0.15 * size * square[:, 1], axis=1) for size in (9, reach)
    )
    lost = 1e-15 * reach + ROUNDING
    np.testing.assert_allclose(transmittance(far), transmittance(near), atol=lost)


def test_rounding_in_coordinates_changes_nothing():
    generator = np.random.default_rng(0)
    walls = np.array(
        [
            across_x(3, (1, 4), (1, 3)),
            across_x(2.5, (1, 4), (1, 3)),
            [(0.5, 0.5, 0), (4.5, 4.5, 0), (4.5, 4.5, 4), (0.5, 0.5, 4)],
            [(1, 3, 0.5), (3, 1, 0.5), (4, 2, 2.5), (2, 4, 2.5)],
        ]
    )
    noisy = walls + 1e-12 * generator.normal(size=walls.shape)
    np.testing.assert_allclose(transmittance(*noisy), transmittance(*walls), atol=1e-11)


def test_a_free_edge_reaches_an_eighth_of_a_cell_too_far_on_average():
    """The price of the centre-ray rule, as in 2D."""
    count = 200
    walls = [across_x(3, (j, j + (j + 0.5) / count), (0, 1)) for j in range(count)]
    tau = transmittance(*walls, grid=Grid((6, count, 1)), offsets=[(1, 0, 0)])
    assert 0.5 - tau[0, 2].mean() == pytest.approx(0.125, abs=0.003)


# -- against other ways to the same numbers -------------------------------------------------------


def are_hit(origins, step, triangles):
    """Whether rays origins (N, 3) + t step, 0 ≤ t ≤ 1, meet any triangle (Möller & Trumbore)."""
    first, one, other = (
        triangles[:, 0],
        triangles[:, 1] - triangles[:, 0],
        triangles[:, 2] - triangles[:, 0],
    )
    across = np.cross(step, other)
    scale = np.sum(one * across, axis=1)
    gap = origins[:, None] - first
    turned = np.cross(gap, one)
    u, v = np.sum(gap * across, axis=-1) / scale, turned @ step / scale
    t = np.sum(turned * other, axis=-1) / scale
    return np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1), axis=1)


def beam(step, side, generator):
    """Rays of a beam round the origin, one in each of side² squares: they start in the middle of
    their way through the unit cell."""
    across = np.linalg.svd(np.array(step, float)[None])[2][1:]
    squares = np.stack(np.meshgrid(*[np.arange(side)] * 2), axis=-1).reshape(-1, 2)
    places = (2 * (squares + generator.random(squares.shape)) / side - 1) @ across
    moving = np.array(step) != 0
    ends = np.array([-0.5, 0.5])[:, None, None] - places[:, moving]
    ends = np.sort(ends / np.array(step)[moving], axis=0)
    enter, leave = ends[0].max(axis=1), ends[1].min(axis=1)
    inside = (enter < leave) & np.all(np.abs(places[:, ~moving]) <= 0.5, axis=1)
    return (places + 0.5 * (enter + leave)[:, None] * step)[inside]


@pytest.mark.parametrize(
    ("walls", "parts"),
    [
        pytest.param(random_triangles(1, 1), None, id="one"),
        pytest.param(random_triangles(2, 12), None, id="many"),
        pytest.param([laid(L_SHAPE, 4)], [laid(part, 4) for part in L_PARTS], id="not convex"),
        pytest.param([laid(L_SHAPE[[0, 1, 3, 5]], 5), *random_triangles(5, 4)], None, id="dart"),
    ],
)
def test_shares_equal_those_of_many_parallel_rays(walls, parts):
    generator, tau = np.random.default_rng(8), transmittance(*walls)
    triangles = triangles_of(parts or walls)
    partly = np.argwhere((tau > 0) & (tau < 1))
    others = np.argwhere((tau == 0) | (tau == 1))
    chosen = [*generator.permutation(partly)[:40], *generator.permutation(others)[:40]]
    side = 64
    for d, *cell in chosen:
        step, centre = NEIGHBOURS[d], np.array(cell) + 0.5
        rays = centre + beam(step, side, generator)
        # Jittered rays miss the area by its outline times a part of their distance.
        tolerance = 6 / side**1.5
        counted = 1 - are_hit(rays, step, triangles).mean()
        if are_hit(centre[None], step, triangles).any():
            counted = 0.0
        assert tau[(d, *cell)] == pytest.approx(counted, abs=tolerance), (step, cell)


def flat_walls(seed):
    """Walls (S, 4) in 2D: in general position, and on grid lines, through centres and corners."""
    generator = np.random.default_rng(seed)
    middles, halves = generator.random((8, 2)) * (6, 5), generator.normal(size=(8, 2))
    slanted = np.hstack([middles - halves, middles + halves])
    return np.concatenate([slanted, generator.integers(0, 12, (5, 4)) / 2])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("axis", range(3))
def test_tall_walls_block_as_in_2d(seed, axis):
    """Links across the long axis, in every layer."""
    flat = [step for step in NEIGHBOURS if step[axis] == 0]
    ends = flat_walls(seed)
    segments = [Segment(wall[:2], wall[2:], np.zeros(1)) for wall in ends]
    expected = exact_transmittance(Grid((6, 5)), segments, np.delete(flat, axis, axis=1))
    corners = np.stack([ends[:, :2], ends[:, 2:], ends[:, 2:], ends[:, :2]], axis=1)
    heights = np.tile([0.0, 0.0, 3.0, 3.0], (len(ends), 1))
    tall = np.insert(corners, axis, heights, axis=2)
    shape = tuple(np.insert((6, 5), axis, 3).tolist())
    found = np.moveaxis(transmittance(*tall, grid=Grid(shape), offsets=flat), 1 + axis, 0)
    for layer in found:
        np.testing.assert_allclose(layer, expected, rtol=0, atol=ROUNDING)


# -- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize("offsets", [[], (1, 0, 0), [(0, 0, 0)], [(1, 2, 0)], [(1, 0)]])
def test_offsets_to_other_than_neighbours_are_refused(offsets):
    with pytest.raises(InputError, match="offsets"):
        exact_transmittance(GRID, facets(across_x(3, (0, 1), (0, 1))), offsets)


def test_walls_that_are_no_facets_are_refused():
    segment = Segment(np.zeros(2), np.ones(2), np.zeros(1))
    with pytest.raises(InputError, match="walls"):
        exact_transmittance(GRID, [segment], NEIGHBOURS)


@pytest.mark.parametrize(
    "vertices",
    [
        [(0, 0, 0), (1, 0, 0), (0, np.nan, 1)],
        [(0, 0), (1, 0), (0, 1)],
        pytest.param([(0, 0, 1), (3, 0, 1), (0, 2, 1), (2, 3, 1)], id="edges that cross"),
    ],
)
def test_facets_that_are_none_are_refused(vertices):
    facet = Facet(np.array(vertices, float), np.zeros(1))
    with pytest.raises(InputError, match="facets"):
        exact_transmittance(GRID, [facet], NEIGHBOURS)
