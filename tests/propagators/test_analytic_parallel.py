"""Analytic reference: parallel light, exact in space."""

import numpy as np
import pytest
from analytic_scenes import WALLS, make_scene, outline, random_scene, room
from test_analytic_montecarlo import SIZE, crossings, nearest_hit

from flatland.harmonics import CircularHarmonics
from propagators.analytic import Analytic
from propagators.analytic.balance import arriving_flux
from propagators.analytic.geometry import read_geometry

SLANTED = (0.6, -0.8)
ROUNDING = 1e-12


def sunlit(way=SLANTED, walls=WALLS, strength=2.0, **more):
    return make_scene(lights=more.pop("lights", ()), walls=walls, beams=[(way, strength)], **more)


def test_shadow_edges_fall_where_straight_lines_say():
    scene = sunlit((0, -1), [((1.25, 5), (4.5, 5.5))])
    flux = Analytic().solve(scene, 1).scalar_flux()
    lit = np.ones((8, 8))
    lit[1, :5], lit[2:4, :5], lit[4, :5] = 0.25, 0, 0.5
    # The wall crosses row 5: light arrives there, and what lies below it is dark.
    np.testing.assert_allclose(flux[:, [0, 4, 6, 7]], 2 * lit[:, [0, 4, 6, 7]], atol=ROUNDING)


def test_slanted_shadow_edges_go_through_the_corners_of_cells():
    """Direction (1, -1)/√2, wall from (2, 6) to (4, 6): the shadow is 8 < x + y < 10, y < 6."""
    flux = Analytic().solve(sunlit((1, -1), [((2, 6), (4, 6))], np.sqrt(2)), 1).scalar_flux()
    # A lit cell passes irradiance √2 over a width of √2. Of the cell (i, j), light that leaves
    # over its lower left half has x + y < i + j + 1.
    corner = np.add.outer(np.arange(8), np.arange(8))
    below = np.arange(8) < 6
    expected = np.full((8, 8), 2.0)
    expected[(corner == 8) & below] = 0
    expected[((corner == 7) | (corner == 9)) & below] = 1
    np.testing.assert_allclose(flux, expected, rtol=0, atol=ROUNDING)


def test_light_is_one_direction_in_angle():
    scene = sunlit()
    field = Analytic().solve(scene, 5)
    delta = CircularHarmonics(5).evaluate([SLANTED])[0]
    np.testing.assert_allclose(field.values, delta[:, None, None] * field.scalar_flux(), atol=1e-12)


@pytest.mark.parametrize("way", [SLANTED, (1, 0), (0, -1), (-1, 1e-9), (-0.8, -0.6)])
def test_flux_agrees_with_dense_rays(way):
    unit = np.array(way) / np.hypot(*way)
    across = np.array([-unit[1], unit[0]])
    count, reach = 40_000, 6.0
    places = (np.arange(count) + 0.5) / count * 2 * reach - reach
    origins = np.array([4.0, 4.0]) - 20 * unit + places[:, None] * across
    ways = np.broadcast_to(unit, origins.shape) + 1e-13
    flux = np.zeros((SIZE, SIZE))
    for cells, _ in crossings(origins, ways, nearest_hit(origins, ways, WALLS)):
        np.add.at(flux, cells, 2 * 2 * reach / count)
    found = Analytic().solve(sunlit(way), 1).scalar_flux()
    # Each of a few edges in a cell is placed to one ray.
    np.testing.assert_allclose(found, flux, rtol=0, atol=8 * 2 * 2 * reach / count)


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(8))
def test_flux_balances_in_random_scenes(seed, step):
    beams = [((0.28, 0.96), 1.0), ((-1, 0), 0.5), ((1, -1), 0.3)]
    scene = random_scene(seed, step=step, beams=beams)
    assert abs(Analytic().energy(scene).closure) < 10 * ROUNDING


def test_as_much_flux_leaves_an_empty_cell_as_enters_it():
    scene = sunlit(walls=WALLS[:2])
    geometry = read_geometry(scene)
    entering = arriving_flux(geometry, geometry.cell_outlines().reshape(-1, 4)[:, [2, 3, 0, 1]])
    net = entering.reshape(8, 8, 4).sum(axis=2) - Analytic().solve(scene, 1).scalar_flux()
    empty = np.ones((8, 8), bool)
    empty[2:5, 2:5] = False
    np.testing.assert_allclose(net[empty], 0, atol=ROUNDING)


@pytest.mark.parametrize("spacing", [1.0, 0.25])
def test_what_comes_in_is_irradiance_times_the_width_of_the_grid(spacing):
    ledger = Analytic().energy(sunlit(spacing=spacing))
    assert ledger.emitted == pytest.approx(2 * 1.4 * 8 * spacing)
    assert abs(ledger.closure) < ROUNDING


@pytest.mark.parametrize("albedo", [0.0, 0.7])
def test_walls_on_the_border_keep_the_light_out(albedo):
    scene = sunlit(walls=room(), albedo=albedo)
    np.testing.assert_allclose(Analytic().solve(scene, 2).values, 0, atol=ROUNDING)
    ledger = Analytic().energy(scene)
    assert abs(ledger.closure) < ROUNDING
    assert ledger.left == pytest.approx(albedo * ledger.emitted)


def test_a_slanted_wall_reflects_like_a_light():
    """One wall lit evenly on one side sends ρ E⊥ l |n·ω| from there, whatever the element."""
    wall, albedo = ((2, 2), (5, 3)), 0.6
    scene = sunlit(walls=[wall], albedo=albedo)
    lit = 2 * (0.6 * 1 + 0.8 * 3)
    assert Analytic().absorbed(scene)[0] == pytest.approx((1 - albedo) * lit)
    bounced = Analytic().solve(scene, 6).values - Analytic(bounces=False).solve(scene, 6).values
    light = Analytic().solve(make_scene(lights=[(*wall, albedo * lit)], walls=()), 6).values
    np.testing.assert_allclose(bounced, light, rtol=0, atol=ROUNDING)


def test_a_shadow_ends_between_two_elements():
    """Then irradiance does not jump on an element, and what is sent is exact to second order."""
    scene = sunlit((0.6, -0.8), [((0, 1), (8, 1)), ((1, 5), (3.3, 5))], albedo=0.5)
    light = Analytic(element=0.9, bounces=False).irradiance(scene)
    floor = light.irradiance[(light.segments == 0) & (light.stops[:, 0] > light.starts[:, 0])]
    shade = np.isclose(floor, 0, atol=ROUNDING) | np.isclose(floor, 1.6, rtol=1e-12)
    assert shade.all()
    assert 0 < np.sum(floor < 1) < floor.size


def test_sky_and_sun_shine_together():
    """Environment light stands on the border; it is no wall to what comes from behind it."""
    sky = {"kind": "environment", "radiance": 0.3}
    alone, both = (sunlit(points=points, albedo=0.5) for points in ([], [sky]))
    sun = Analytic(bounces=False)
    without = make_scene(lights=(), points=[sky])
    difference = sun.solve(both, 3).values - sun.solve(without, 3).values
    np.testing.assert_allclose(difference, sun.solve(alone, 3).values, rtol=0, atol=ROUNDING)
    ledger = Analytic().energy(both)
    assert ledger.emitted == pytest.approx(2 * 1.4 * 8 + 0.3 * 2 * 32)
    assert abs(ledger.closure) < 10 * ROUNDING


def test_intensity_leaves_parallel_light_out():
    assert not Analytic().intensity(sunlit(), [SLANTED]).any()


def test_colours_have_their_own_irradiance():
    found = Analytic().solve(sunlit(strength=[2.0, 0.5], albedo=0.4), 3).values
    grey = Analytic().solve(sunlit(albedo=0.4), 3).values
    np.testing.assert_allclose(found, np.stack([grey, grey / 4]), rtol=0, atol=ROUNDING)


def test_a_box_in_the_sun_is_dark_inside():
    flux = Analytic().solve(sunlit(walls=outline((2, 2), (6, 2), (6, 6), (2, 6))), 1).scalar_flux()
    # Its outermost cells take no light either: the walls lie on their faces.
    np.testing.assert_allclose(flux[2:6, 2:6], 0, atol=ROUNDING)


@pytest.mark.parametrize("walls", [[], [((0, 8), (8, 8))], [((0, 8), (3, 8)), ((2, 4), (6, 3))]])
def test_a_light_on_the_border_lets_parallel_light_in_unless_a_wall_backs_it(walls):
    scene = sunlit(walls=walls, lights=[((5, 8), (2, 8), 1.0)], albedo=0.5)
    ledger = Analytic().energy(scene)
    assert abs(ledger.closure) < ROUNDING
    lit = Analytic(bounces=False).irradiance_at(scene, [(4, 7.9)], [(0, 1)])[0] > 1
    assert lit == (not walls)
