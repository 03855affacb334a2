"""Shadow maps: who receives how much of a lamp's light."""

import numpy as np
import pytest
from shadow_maps import assert_books_of_colours, received

from flatland.grid import Grid
from flatland.shadow_map import (
    map_directional_light,
    map_point_light,
    reflected_flux,
)
from flatland.sources import Segment

GRID = Grid((16, 12), 0.5, (1.0, -2.0))
ROUNDING = 1e-13
#: Walls in cells: slanted ones, two that cross, one on a cell border, one that sticks out.
WALLS = (((2, 2), (10, 3.3)), ((5, 1), (6.4, 8)), ((3, 6), (8, 5)), ((0, 11), (16, 11)))
WALLS = (*WALLS, ((12, -9), (14.5, 10)))


def wall(start, stop, albedo=0.5):
    return Segment(GRID.to_world(start), GRID.to_world(stop), np.array(albedo))


def point_map(walls, position=(7.3, 4.1), texels=256):
    return map_point_light(GRID, walls, GRID.to_world(position), texels)


def sun_map(walls, direction=(0.6, -0.8), texels=256):
    return map_directional_light(GRID, walls, np.array(direction), texels)


EVERY_MAP = pytest.mark.parametrize("make", [point_map, sun_map])


@pytest.mark.parametrize("texels", [1, 7, 256])
@pytest.mark.parametrize(("distance", "length"), [(1.0, 4.0), (3.0, 0.5), (0.01, 6.0)])
def test_wall_in_front_of_a_point_receives_the_share_of_its_angle(distance, length, texels):
    walls = [wall((8 - length / 2, 5 - distance), (8 + length / 2, 5 - distance))]
    found = point_map(walls, (8, 5), texels)
    expected = np.arctan(length / 2 / distance) / np.pi
    assert found.received.sum() == pytest.approx(expected, rel=1e-12)
    assert found.emitted == pytest.approx(1.0)
    assert found.escaped == pytest.approx(1 - expected)


@pytest.mark.parametrize("texels", [1, 7, 256])
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2, 2.8])
def test_slanted_wall_in_parallel_light_receives_its_width_across(angle, texels):
    along = 2.0 * np.array([np.cos(angle), np.sin(angle)])
    walls = [wall(np.array([8, 6]) - along, np.array([8, 6]) + along)]
    expected = 2 * abs(along[0] * -0.8 - along[1] * 0.6) * GRID.spacing
    assert sun_map(walls, texels=texels).received.sum() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("direction", "width"), [((1, 0), 6.0), ((0, -1), 8.0), ((0.6, 0.8), 10)])
def test_sun_sends_in_what_the_grid_is_wide_across_it(direction, width):
    assert sun_map([], direction).emitted == pytest.approx(width)
    assert sun_map([], direction).escaped == pytest.approx(width)


@EVERY_MAP
def test_number_of_texels_changes_no_flux(make):
    walls = [wall(*ends) for ends in WALLS]
    fine = received(make(walls, texels=1000), walls)
    for texels in (1, 2, 5, 64):
        np.testing.assert_allclose(received(make(walls, texels=texels), walls), fine, atol=ROUNDING)


def first_hits(origins, directions, walls):
    """Which wall each ray meets first in the grid, by brute force; -1 for none."""
    best, owner = np.full(len(origins), 1e9), np.full(len(origins), -1)
    for number, (a, b) in enumerate(np.array(walls, float)):
        along = b - a
        across = directions[:, 0] * along[1] - directions[:, 1] * along[0]
        across = np.where(across == 0, 1e-30, across)
        way = a - origins
        distance = (way[:, 0] * along[1] - way[:, 1] * along[0]) / across
        part = (way[:, 0] * directions[:, 1] - way[:, 1] * directions[:, 0]) / across
        point = a + np.clip(part, 0, 1)[:, None] * along
        inside = np.all((point >= -1e-9) & (point <= np.array(GRID.shape) + 1e-9), axis=1)
        # Where walls lie on one another the first listed counts, as in the map.
        nearer = distance < best * (1 - 1e-9)
        hit = (distance > 0) & (part >= 0) & (part <= 1) & inside & nearer
        best[hit], owner[hit] = distance[hit], number
    return owner


def random_walls(rng, snapped):
    ends = rng.uniform(-2, 18, (rng.integers(1, 25), 2, 2))
    ends = np.round(ends) if snapped else ends
    return ends[np.any(ends[:, 0] != ends[:, 1], axis=1)]


@pytest.mark.parametrize("snapped", [False, True])
def test_point_light_agrees_with_rays(rng, snapped):
    angles = (np.arange(20_000) + 0.5) * np.pi / 10_000
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for _ in range(30):
        ends, position = random_walls(rng, snapped), rng.uniform(1, 11, 2)
        owner = first_hits(np.tile(position, (len(rays), 1)), rays, ends)
        walls = [wall(*pair) for pair in ends]
        expected = np.bincount(owner[owner >= 0], minlength=len(walls)) / len(rays)
        found = received(point_map(walls, position, 64), walls)
        # Each shadow edge may fall on either side of a ray.
        np.testing.assert_allclose(found, expected, atol=20 / len(rays))


@pytest.mark.parametrize("snapped", [False, True])
def test_directional_light_agrees_with_rays(rng, snapped):
    corners = np.array([[0, 0], [16, 0], [0, 12], [16, 12]])
    for _ in range(30):
        ends, angle = random_walls(rng, snapped), rng.uniform(0, 2 * np.pi)
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        low, high = (corners @ across).min(), (corners @ across).max()
        places = low + (np.arange(20_000) + 0.5) * (high - low) / 20_000
        origins = places[:, None] * across - 100 * along
        owner = first_hits(origins, np.tile(along, (len(places), 1)), ends)
        walls = [wall(*pair) for pair in ends]
        unit = (high - low) * GRID.spacing / len(places)
        expected = np.bincount(owner[owner >= 0], minlength=len(walls)) * unit
        found = received(sun_map(walls, along, 64), walls)
        np.testing.assert_allclose(found, expected, atol=20 * unit)


def test_closed_outline_with_shared_vertices_lets_nothing_escape(rng):
    angles = np.sort(rng.uniform(0, 2 * np.pi, 400))
    radius = rng.uniform(1.0, 4.5, 400)
    corners = np.array([8, 6]) + radius[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    walls = [wall(a, b) for a, b in zip(corners, np.roll(corners, -1, axis=0))]
    assert abs(point_map(walls, (8.001, 6.002), 16).escaped) < 1e-12


def test_shadow_takes_from_the_wall_behind_what_the_blocker_gets():
    behind, blocker = wall((2, 1), (14, 1)), wall((7, 3), (9, 3.5))
    alone = received(point_map([behind], (8, 5)), [behind])
    both = received(point_map([behind, blocker], (8, 5)), [behind, blocker])
    only = received(point_map([blocker], (8, 5)), [blocker])
    assert both[1] == pytest.approx(only[0], rel=1e-12)
    assert both[0] == pytest.approx(alone[0] - only[0], rel=1e-12)


def test_shadow_in_parallel_light_is_as_wide_as_the_blocker():
    walls = [wall((0, 1), (16, 1)), wall((5, 8), (7, 8)), wall((6, 4), (8, 4))]
    found = received(sun_map(walls, (0.0, -1.0)), walls) / GRID.spacing
    np.testing.assert_allclose(found, [13, 2, 1], atol=ROUNDING)


def test_crossing_walls_are_lit_up_to_where_they_cross():
    # Seen from above, an X shows the upper half of either arm.
    walls = [wall((6, 4), (10, 8)), wall((10, 4), (6, 8))]
    found = sun_map(walls, (0.0, -1.0), texels=3)
    np.testing.assert_allclose(received(found, walls), [1.0, 1.0], atol=ROUNDING)
    assert GRID.to_cells(np.concatenate([found.starts, found.stops]))[:, 1].min() > 6 - ROUNDING
    halves = received(point_map(walls, (8, 9)), walls) * 2 * np.pi
    np.testing.assert_allclose(halves, np.arctan(2), rtol=1e-12)


def test_what_is_outside_the_grid_or_seen_from_its_end_has_no_effect():
    walls = [wall((-3, -1), (19, -1)), wall((17, 0), (17, 12)), wall((9, 4.1), (12, 4.1))]
    assert received(point_map(walls, (7.3, 4.1)), walls).sum() == 0
    assert received(sun_map(walls, (1.0, 0.0)), walls).sum() == 0
    assert received(sun_map(walls, (0.0, -1.0)), walls)[2] == pytest.approx(1.5)


def test_part_of_a_wall_inside_the_grid_counts():
    outside = [wall((-1000, 2), (1e7, 2))]
    assert sun_map(outside, (0.0, -1.0)).received.sum() == pytest.approx(8.0)


def test_of_two_walls_in_one_place_the_first_is_lit():
    walls = [wall((2, 1), (14, 2)), wall((14, 2), (2, 1)), wall((2, 1), (8, 1.5))]
    for found in (point_map(walls), sun_map(walls)):
        assert set(found.walls) == {0}


@EVERY_MAP
def test_pieces_lie_on_their_walls_and_face_the_light(make):
    walls = [wall(*ends) for ends in WALLS]
    found = make(walls)
    lit = [walls[number] for number in found.walls]
    starts, stops = (np.array([getattr(w, end) for w in lit]) for end in ("start", "stop"))
    for places in (found.starts, found.stops, found.positions):
        offset, along = places - starts, stops - starts
        distance = np.abs(offset[:, 0] * along[:, 1] - offset[:, 1] * along[:, 0])
        np.testing.assert_allclose(distance / np.hypot(*along.T), 0, atol=ROUNDING)
    light = GRID.to_world((7.3, 4.1)) - found.positions if make is point_map else [-0.6, 0.8]
    cosines = np.sum(found.normals * light, axis=1) / np.linalg.norm(light, axis=-1)
    assert (cosines > 0).all()
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1, atol=ROUNDING)
    tolerance = 1e-12 if make is sun_map else 1e-3  # the middle of an arc is not that of a piece
    np.testing.assert_allclose(found.cosines, cosines, atol=tolerance)
    assert (np.diff(found.texels) >= 0).all()
    assert {*found.texels} <= {*range(256)}


@EVERY_MAP
def test_budget_of_a_coloured_lamp_among_coloured_walls(make):
    albedos = [(0.5, 0.0, 1.0), 0.25, (0.1, 0.2, 0.3), 0.0, 1.0]
    walls = [wall(*ends, albedo) for ends, albedo in zip(WALLS, albedos)]
    assert_books_of_colours(make(walls), walls, np.array([1.0, 2.0, 0.0]))


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.3])
def test_lpv2009_is_darker_by_the_cosine_of_a_tilted_wall(angle):
    along = 2.0 * np.array([np.cos(angle), np.sin(angle)])
    walls = [wall(np.array([8, 6]) - along, np.array([8, 6]) + along)]
    found = sun_map(walls, (0.0, -1.0))
    exact, dark = (reflected_flux(found, walls, np.ones(1), w).sum() for w in ("exact", "lpv2009"))
    assert dark / exact == pytest.approx(np.cos(angle), rel=1e-12)


def test_lpv2009_weights_a_point_light_by_its_cosine():
    walls = [wall((5, 2), (11, 2))]
    half = np.arctan(3 / 3)
    found = reflected_flux(point_map(walls, (8, 5)), walls, np.ones(1), "lpv2009").sum()
    # ∫ albedo cos θ dθ / 2π over the wall's angle; the middle of each texel stands for it.
    assert found == pytest.approx(0.5 * np.sin(half) / np.pi, rel=1e-4)
