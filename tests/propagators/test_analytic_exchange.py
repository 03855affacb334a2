"""Analytic reference: form factors between walls, and light of panels against the older kernel."""

import numpy as np
import pytest
from analytic_scenes import make_scene, outline, random_scene, room

from propagators.analytic.balance import arriving_flux
from propagators.analytic.elements import cut_walls
from propagators.analytic.exchange import exchange_matrix
from propagators.analytic.geometry import read_geometry
from propagators.analytic.radiosity import bounce
from propagators.analytic.targets import collect_light

ROUNDING = 1e-13


def form_factors(*plates, walls=()):
    """F (K, K) between plates (start, stop) that light their left, past themselves and walls."""
    segments = np.array([(*a, *b) for a, b in plates], float)
    every = np.array([(*a, *b) for a, b in (*plates, *walls)], float)
    exchange = exchange_matrix(segments, np.arange(len(plates) + 1), segments, every)
    return exchange / (2 * np.hypot(*(segments[:, 2:] - segments[:, :2]).T))[:, None]


def room_elements(size=0.5, **scene):
    geometry = read_geometry(make_scene(lights=(), albedo=0.5, **scene))
    elements = cut_walls(geometry, size, np.ones(len(geometry.walls), bool))
    lit = elements.panels, elements.first, elements.segments, geometry.walls
    return geometry, elements, exchange_matrix(*lit)


def test_parallel_plates():
    # Two plates of width w at distance d: F = sqrt(1 + (d/w)^2) - d/w.
    plates = ((4, 1), (1, 1)), ((1, 5), (4, 5))
    factors = form_factors(*(plate[::-1] for plate in plates))
    assert factors[0, 1] == pytest.approx(np.sqrt(1 + (4 / 3) ** 2) - 4 / 3, abs=ROUNDING)


def test_perpendicular_plates_with_a_common_edge():
    # Widths a and b: F = (a + b - sqrt(a^2 + b^2)) / 2a.
    factors = form_factors(((1, 1), (3, 1)), ((3, 1), (3, 6)))
    assert factors[0, 1] == pytest.approx((2 + 5 - np.sqrt(29)) / 4, abs=ROUNDING)
    assert factors[1, 0] == pytest.approx((2 + 5 - np.sqrt(29)) / 10, abs=ROUNDING)


def test_plates_back_to_back_and_on_one_line_see_nothing():
    back, line = ((4, 1), (1, 1)), ((5, 1), (7, 1))
    assert not form_factors(back, ((4, 5), (1, 5))[::-1], line)[0].any()


def test_a_wall_between_hides_what_lies_behind():
    plates = ((1, 1), (4, 1)), ((4, 5), (1, 5))
    assert form_factors(*plates, walls=[((0, 3), (5, 3))])[0, 1] == 0
    # Half a wall: both crossed strings and the bent one touch its tip and are 5 long.
    free, left, right = (
        form_factors(*plates, walls=walls)[0, 1]
        for walls in ([], [((0, 3), (2.5, 3))], [((2.5, 3), (5, 3))])
    )
    assert left == pytest.approx((5 + 5 - 5 - 4) / 6, abs=ROUNDING)
    assert left + right == pytest.approx(free, abs=ROUNDING)


@pytest.mark.parametrize("walls", [room(), [*room(), *outline((2, 2), (5, 3), (3, 6))]])
def test_a_closed_room_gets_all_that_its_walls_send(walls):
    _, elements, exchange = room_elements(walls=walls)
    sums = exchange.sum(axis=1) / (2 * elements.lengths)
    outside = sums == 0  # the far sides of the room's walls
    assert outside.sum() == 64
    np.testing.assert_allclose(sums[~outside], 1, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("seed", range(8))
def test_elements_lose_only_what_meets_lights_or_the_border(seed):
    """Closure, past crossing walls: each pair is computed once, so reciprocity is built in."""
    geometry = read_geometry(random_scene(seed, albedo=0.5))
    elements = bounce(geometry, 2.0).elements
    lit = elements.panels, elements.first, elements.segments
    exchange = exchange_matrix(*lit, geometry.walls)
    targets = np.concatenate([geometry.border, geometry.emitters])[:, None]
    targets = np.concatenate([targets, targets[:, :, [2, 3, 0, 1]]])
    ones = np.ones((1, 1))
    lost = [
        collect_light(targets, element[None], ones, geometry.walls, 1).sum()
        for element in elements.segments
    ]
    sums = exchange.sum(axis=1) + lost
    np.testing.assert_allclose(sums, 2 * elements.lengths, rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_panels_send_what_their_elements_send_one_by_one(seed, step):
    geometry = read_geometry(random_scene(seed, step=step, albedo=0.5))
    bounced, outlines = bounce(geometry, 0.7), geometry.cell_outlines()
    lights = bounced.elements.segments, bounced.radiosity / 2
    expected = collect_light(outlines, *lights, geometry.walls, 5)
    found = bounced.arriving(outlines, geometry.walls, 5)
    assert np.abs(expected).max() > 1e-3
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("seed", range(3))
def test_radiosity_is_albedo_times_what_arrives(seed):
    geometry = read_geometry(random_scene(seed, albedo=0.6))
    bounced = bounce(geometry, 1.0)
    flux = arriving_flux(geometry, bounced.elements.segments, bounced)
    expected = 0.6 * flux / bounced.elements.lengths[:, None]
    np.testing.assert_allclose(bounced.radiosity, expected, rtol=0, atol=ROUNDING)


def test_walls_end_at_the_border_and_count_once():
    walls = [((-4, 3), (12, 3)), ((2, 3), (5, 3)), ((3, 1), (3, 6))]
    _, elements, _ = room_elements(size=1.0, walls=walls)
    # 8 cells in two panels, none for the wall on it, 5 cells in two panels; two sides each.
    assert len(elements.panels) == 8
    assert elements.lengths.sum() == pytest.approx(2 * (8 + 5))
    assert elements.lengths.max() <= 1 + ROUNDING
