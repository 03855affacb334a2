"""Analytic reference in 3D: light that walls send back."""

from dataclasses import replace

import numpy as np
import pytest
from volumes import (
    area_of,
    box,
    cornell,
    moved,
    point,
    rectangle,
    room,
    unit,
    volume,
)

from flatland.errors import ConvergenceError
from flatland.harmonics import SphericalHarmonics
from propagators.analytic import Analytic
from propagators.analytic_3d.cells import cell_intensity, cell_light
from propagators.analytic_3d.directions import even_beams
from propagators.analytic_3d.elements import cut_walls
from propagators.analytic_3d.geometry import read_geometry
from propagators.analytic_3d.radiosity import bounce, exchange_matrix

SIZE = (4, 3, 5)
LAMP = point((1.5, 1.5, 3.5), 2.0)
#: A box that stands on the floor, on no grid plane, with a slanted triangle through it.
THINGS = [
    *box((1.2, 0.7, 0), (2.6, 1.9, 1.6)),
    np.array([(0.5, 0.5, 1), (3, 1, 2.2), (1.8, 2.6, 0.7)]),
]
#: Rounding, and what may be missing of light that is sent to and fro.
ROUNDING, BALANCED = 1e-12, 1e-6


def things(albedo):
    return [(wall[0] if len(wall) == 2 else wall, albedo) for wall in THINGS]


def closed_room(albedo, **more):
    return volume(SIZE, walls=[*room(SIZE, albedo), *things(albedo)], points=[LAMP], **more)


def furnace(albedo, emission=2.0, lines=64):
    """A room and things in it, every side of which emits."""
    geometry = read_geometry(closed_room(albedo))
    elements = cut_walls(geometry, 0.7, 0.7)
    # Emission is sent as the irradiance emission / albedo would be.
    direct = np.full((2 * len(elements.areas), 1), emission / albedo)
    return elements, bounce(geometry, elements, direct, even_beams(lines, 3))


@pytest.mark.parametrize("albedo", [0.1, 0.5, 0.9, 0.99])
def test_walls_that_emit_and_reflect_alike_make_a_furnace(albedo):
    """Uniform emission E: radiosity E / (1 - ρ) everywhere, whatever stands in the room."""
    elements, found = furnace(albedo)
    # Of the walls on the border (the first six) the fronts alone face the room.
    closed = (elements.side_owners >= 6) | (np.arange(2 * len(elements.areas)) % 2 == 0)
    np.testing.assert_allclose(found.radiosity[closed], 2 / (1 - albedo), rtol=1e-10)


def test_radiance_in_a_furnace_is_the_same_in_every_direction():
    _, found = furnace(0.5)
    even = replace(found, radiosity=np.full_like(found.radiosity, np.pi))
    ways = np.array([unit((1, 2, 3)), unit((-3, 0.2, 0.1)), unit((0.1, -1, 0.9))])
    intensity = cell_intensity(even, SIZE, ways)
    expected = np.abs(ways).sum(axis=1)[:, None, None]
    np.testing.assert_allclose(intensity, np.broadcast_to(expected, intensity.shape), rtol=ROUNDING)
    values = cell_light(even, SIZE, 4, even_beams(50, 1), lambda share: None)
    series = (
        SphericalHarmonics(4).clamped_cosine(np.concatenate([np.eye(3), -np.eye(3)])).sum(axis=0)
    )
    np.testing.assert_allclose(values, np.broadcast_to(series, values.shape), atol=ROUNDING)


def test_exchange_is_symmetric_and_meets_areas():
    geometry = read_geometry(closed_room(0.5))
    elements = cut_walls(geometry, 1.0, 1.0)
    exchange, into_open = exchange_matrix(elements, even_beams(2000, 1), SIZE)
    assert abs(exchange - exchange.T).max() == 0
    lines = np.asarray(exchange.sum(axis=1)).ravel() + into_open
    met = lines > 0
    # Lines meet areas in the mean: walls as wholes to some per thousand.
    for owner in np.unique(elements.side_owners):
        own = (elements.side_owners == owner) & met
        assert lines[own].sum() == pytest.approx(np.pi * elements.side_areas[own].sum(), rel=5e-3)


def test_form_factors_between_walls_of_a_cube_are_the_textbooks():
    # Howell's catalogue, C-11 for equal squares at their own distance: 0.199825.
    scene = read_geometry(volume((2, 2, 2), walls=room((2, 2, 2), 0.5)))
    elements = cut_walls(scene, 2.0, 2.0)
    exchange, _ = exchange_matrix(elements, even_beams(4000, 5), (2, 2, 2))
    inside = np.flatnonzero(np.asarray(exchange.sum(axis=1)).ravel() > 0)
    factors = exchange.toarray()[np.ix_(inside, inside)] / (4 * np.pi)
    opposite = [[1, 0], [3, 2], [5, 4]]
    owners = elements.side_owners[inside]
    for first, second in opposite:
        pair = factors[owners == first][:, owners == second]
        assert pair[0, 0] == pytest.approx(0.199825, rel=5e-3)


@pytest.mark.parametrize("albedo", [0.1, 0.5, 0.9])
def test_walls_of_a_closed_room_receive_the_light_over_and_over(albedo):
    light = Analytic(element=1.0).irradiance(closed_room(albedo))
    assert light.areas @ light.irradiance == pytest.approx(2 / (1 - albedo), rel=BALANCED)


@pytest.mark.parametrize("element", [0.6, 50.0])
@pytest.mark.parametrize("spacing", [1.0, 0.25])
def test_books_close_at_any_element(element, spacing):
    lamp = point((1.5, 1.5, 3.5), 2.0, (1, 0.3, -0.5))
    beam = ((0.6, -0.8, 0.2), 1.5)
    scene = volume(SIZE, walls=things(0.8), points=[lamp], beams=[beam], spacing=spacing)
    ledger = Analytic(element=element, tolerance=1e-2).energy(scene)
    dark = Analytic(bounces=False).energy(scene)
    # Slivers where walls cross may be met by no line: what they would send on is lost.
    assert abs(ledger.closure) < 1e-4 * ledger.emitted
    assert ledger.absorbed < 0.5 * dark.absorbed
    assert ledger.left > dark.left


def test_books_of_area_lights_close_to_the_tolerance():
    light = rectangle((1, 1, 4.9), (0, 1, 0), (1, 0, 0))
    scene = volume(SIZE, [(light, 3.0)], [*room(SIZE, 0.7), *things(0.4)])
    ledger = Analytic(tolerance=1e-3).energy(scene)
    assert ledger.left == 0
    assert abs(ledger.closure) < 1e-3 * 3


@pytest.mark.parametrize("colours", [False, True])
def test_a_wall_in_the_sun_is_a_light(colours):
    """Even irradiance on a flat wall that sees no other: one bounce, known in closed form."""
    wall, way = rectangle((1.3, 1.2, 1.1), (2.2, 0, 0), (0, 1.9, 0)), np.array([0.2, 0.3, -1])
    albedo, strength = ([0.6, 0.2], [2.0, 1.0]) if colours else (0.6, 2.0)
    sun = volume((4, 4, 4), walls=[(wall, albedo)], beams=[(way, strength)])
    flux = np.multiply(albedo, strength) * area_of(wall) / np.linalg.norm(way)
    lamp = volume((4, 4, 4), [(wall, flux)])
    tolerance = 2e-3
    lit = Analytic(tolerance=tolerance).solve(sun, 3).values
    bounced = lit - Analytic(bounces=False).solve(sun, 3).values
    exact = Analytic(bounces=False).solve(lamp, 3).values
    assert np.linalg.norm(bounced - exact) < tolerance * np.linalg.norm(lit)
    assert np.linalg.norm(exact) > 0.1 * np.linalg.norm(lit)


def test_two_walls_send_light_to_and_fro_like_a_geometric_series():
    """Infinitely wide plates would keep the share ρ each time; here each side keeps F ρ of it.

    The lit plate's mean radiosity after any number of bounces lies between the first bounce and
    the series of the largest form factor that the other plate can have.
    """
    low, high = (
        rectangle((0, 0, 0.5), (4, 0, 0), (0, 4, 0)),
        rectangle((0, 0, 1.5), (0, 4, 0), (4, 0, 0)),
    )
    albedo, factor = 0.8, 0.6327  # C-11 for squares of side 4 at distance 1
    scene = volume((4, 4, 4), walls=[(low, albedo), (high, albedo)], points=[point((2, 2, 1), 1.0)])
    flux = Analytic(element=0.5).absorbed(scene)
    direct = Analytic(bounces=False).absorbed(scene)
    np.testing.assert_allclose(flux[0], flux[1], rtol=2e-2)
    np.testing.assert_allclose(direct[0], direct[1], rtol=ROUNDING)
    once, all_of_it = 1 + albedo * factor, 1 / (1 - albedo)
    assert once * (1 - albedo) < flux.sum() / direct.sum() < all_of_it * (1 - albedo)


def test_black_walls_send_nothing_back():
    scene = closed_room(0.0)
    with_bounces, without = (
        Analytic(bounces=each).solve(scene, 2).values for each in (True, False)
    )
    np.testing.assert_array_equal(with_bounces, without)
    assert Analytic().bounce_error(scene, 2) == 0


def test_light_inside_a_closed_box_stays_there():
    inner = [(v, 0.8) for v, _ in box((1.1, 0.8, 1.2), (2.9, 2.3, 3.8))]
    scene = volume(SIZE, walls=inner, points=[point((2, 1.5, 2.5), 1.0)])
    field = Analytic(tolerance=1e-2, element=1.0).solve(scene, 1).scalar_flux()
    assert field[0].max() == 0
    assert field[:, :, 0].max() == 0
    assert field[1, 1, 2] > 1
    ledger = Analytic(tolerance=1e-2).energy(scene)
    assert ledger.left == 0
    assert ledger.absorbed == pytest.approx(1, rel=BALANCED)


def test_a_lit_ceiling_colours_the_floor():
    red = (room((4, 4, 4))[5][0], [0.9, 0.0])
    scene = volume((4, 4, 4), walls=[red], points=[point((2, 2, 3), [1.0, 1.0])])
    found = Analytic(tolerance=1e-2).irradiance_at(scene, [(2, 2, 1)], [(0, 0, 1)])
    lamp = 1 / (4 * np.pi) / 4
    assert found[1, 0] == pytest.approx(lamp)
    assert found[0, 0] > 1.2 * lamp


def test_finer_elements_change_the_field_by_less_and_less():
    scene = cornell(4, colours=False)
    errors = [
        Analytic(element=size, tolerance=1e-2).bounce_error(scene, 1) for size in (2.0, 1.0, 0.5)
    ]
    assert errors[0] > 1.5 * errors[1] > 2 * errors[2] > 0


def test_irradiance_of_elements_is_that_of_points_on_them():
    scene = volume(
        (4, 4, 4), [(rectangle((1, 1, 3.5), (0, 2, 0), (2, 0, 0)), 3.0)], room((4, 4, 4), 0.5)
    )
    reference = Analytic(element=0.25, tolerance=1e-3)
    light = reference.irradiance(scene)
    floor = np.flatnonzero((light.normals[:, 2] > 0.5) & (light.centres[:, 2] == 0))[::17]
    at = reference.irradiance_at(scene, light.centres[floor], light.normals[floor])
    # What single elements get from one another is sampled, to a few per cent.
    np.testing.assert_allclose(light.irradiance[floor], at, rtol=3e-2)
    assert np.mean(light.irradiance[floor] / at) == pytest.approx(1, abs=3e-3)


def test_places_of_elements_lie_on_their_facets():
    wall = moved(rectangle((0, 0, 0), (2, 0, 1), (0, 2, 0)), 1, 1, 1)
    scene = volume(
        (4, 4, 4), walls=[wall], points=[point((2, 2, 3.5))], spacing=0.5, origin=(1, 2, 3)
    )
    light = Analytic(element=0.6).irradiance(scene)
    assert set(light.facets) == {0}
    assert light.areas.sum() == pytest.approx(2 * 0.25 * area_of(wall))
    facet = scene.facets()[0].vertices
    normal = unit(np.cross(facet[1] - facet[0], facet[2] - facet[0]))
    np.testing.assert_allclose((light.centres - facet[0]) @ normal, 0, atol=ROUNDING)
    assert light.irradiance[light.normals @ normal > 0].min() > 0
    assert light.irradiance[light.normals @ normal < 0].max() == 0


def test_a_closed_room_that_keeps_nothing_is_refused():
    with pytest.raises(ConvergenceError, match="albedo must be below 1"):
        Analytic(element=2.0).solve(closed_room(1.0), 1)


def test_a_tolerance_that_lines_cannot_reach_is_refused():
    scene = volume(SIZE, walls=things(0.5), beams=[((1, 1, -1), 1.0)])
    with pytest.raises(ConvergenceError, match=r"tolerance = 1e-06.*can be reached"):
        Analytic(element=1.0, tolerance=1e-6).solve(scene, 1)
