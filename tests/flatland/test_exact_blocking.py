"""Exact blocking: shares of beams, tight walls, symmetry."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flatland.blocking import exact_transmittance
from flatland.errors import InputError
from flatland.grid import Grid
from flatland.sources import Segment

AXIAL = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
ALL = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
EAST, NORTH_EAST, NORTH, NORTH_WEST, WEST, SOUTH_WEST, SOUTH, SOUTH_EAST = range(8)
GRID = Grid((6, 5))


def walls(*ends):
    """Segments from (x0, y0, x1, y1)."""
    return [Segment(np.array(e[:2], float), np.array(e[2:], float), np.zeros(1)) for e in ends]


def transmittance(*ends, grid=GRID, offsets=ALL):
    tau = exact_transmittance(grid, walls(*ends), offsets)
    return np.ones((len(offsets), *grid.shape)) if tau is None else tau


def random_walls(seed, count, shape=GRID.shape, most=3.0):
    """Walls in general position, also across the grid's border."""
    generator = np.random.default_rng(seed)
    middle = generator.random((count, 2)) * shape
    half = generator.normal(size=(count, 2)) * most / 4
    return np.concatenate([middle - half, middle + half], axis=1)


def closed(vertices):
    """Walls (S, 4) around a polygon (S, 2)."""
    return np.concatenate([vertices, np.roll(vertices, -1, axis=0)], axis=1)


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


def moved(tau, step):
    """tau(x + step) for those x for which x and x + step lie in the grid."""
    return tau[tuple(slice(max(0, s), n + min(0, s)) for s, n in zip(step, tau.shape))]


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


# -- closed walls are tight -----------------------------------------------------------------------


def is_inside(points, ends):
    """Even-odd rule: whether a ray to +x from each point (N, 2) crosses the outline oddly."""
    x, y = points[:, :1], points[:, 1:]
    x0, y0, x1, y1 = ends.T
    rises = (y0 > y) != (y1 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        hit = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
    return (rises & (x < hit)).sum(axis=1) % 2 == 1


def is_on(points, ends):
    """Whether points lie on the outline."""
    start, wall = ends[:, :2], ends[:, 2:] - ends[:, :2]
    gap = points[:, None] - start
    part = np.clip((gap * wall).sum(-1) / np.maximum((wall * wall).sum(-1), 1e-300), 0, 1)
    return (np.linalg.norm(gap - part[..., None] * wall, axis=-1) < 1e-6).any(axis=1)


def connected(tau, offsets):
    """Which cells light can get between, through links with τ > 0: a number per cell."""
    shape = tau.shape[1:]
    number = np.arange(np.prod(shape)).reshape(shape)
    sources, targets = [], []
    for open_share, step in zip(tau, offsets):
        leads = moved(open_share, -step) > 0
        sources.append(moved(number, -step)[leads])
        targets.append(moved(number, step)[leads])
    pairs = np.concatenate(sources), np.concatenate(targets)
    links = coo_array((np.ones(len(pairs[0])), pairs), shape=(number.size, number.size))
    return connected_components(links, directed=False)[1]


def star(generator):
    """A polygon without crossings, anywhere between slim and round."""
    angle = np.sort(generator.random(generator.integers(3, 9))) * 2 * np.pi
    radius = generator.uniform(2, 9, len(angle))
    return 10 + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def lattice(generator):
    """Corners on centres, cell corners and middles of faces; the outline crosses itself."""
    return generator.integers(2, 38, (generator.integers(3, 8), 2)) / 2


def diagonal(generator):
    """Corners on a coarse lattice: many walls along diagonals and through centres."""
    return generator.integers(0, 5, (generator.integers(3, 8), 2)) * 4 + 2.5


@pytest.mark.parametrize("offsets", [AXIAL, ALL], ids=["4", "8"])
@pytest.mark.parametrize("shape", [star, lattice, diagonal])
def test_no_light_gets_through_a_closed_wall(shape, offsets):
    generator, grid = np.random.default_rng(11), Grid((20, 20))
    centers = np.argwhere(np.ones(grid.shape)) + 0.5
    for _ in range(60):
        ends = closed(shape(generator))
        region = connected(transmittance(*ends, grid=grid, offsets=offsets), offsets)
        inside, on = is_inside(centers, ends), is_on(centers, ends)
        assert not np.intersect1d(region[inside & ~on], region[~inside & ~on]).size


def test_without_walls_between_them_cells_stay_connected():
    """The wall is tight because it is there: both sides of it are whole."""
    grid = Grid((20, 20))
    ends = closed(10 + 7.3 * np.array([(1, 0.2), (-0.2, 1), (-1, -0.2), (0.2, -1)]))
    assert len(np.unique(connected(transmittance(*ends, grid=grid, offsets=AXIAL), AXIAL))) == 2


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
