"""Analytic reference: diffuse bounces between walls."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene, outline, random_scene, room

from flatland.errors import ConvergenceError
from flatland.harmonics import CircularHarmonics
from flatland.scene import Scene
from propagators.analytic import Analytic
from propagators.analytic.exchange import exchange_matrix
from propagators.analytic.geometry import read_geometry
from propagators.analytic.radiosity import Bounced, bounce, solve_radiosity

CELL = {"kind": "cell", "cell": [2, 5], "flux": 2.0}
BOX = outline((4.2, 1.3), (6.1, 2.2), (5.0, 4.4))
#: Rounding, in watts of a few emitted.
ROUNDING = 1e-12


def closed_room(albedo, **more):
    return make_scene(lights=(), walls=[*room(), *BOX], points=[CELL], albedo=albedo, **more)


def furnace(albedo):
    """Geometry, exchange and elements of a room whose walls could emit."""
    geometry = read_geometry(closed_room(albedo))
    elements = bounce(geometry, 0.8).elements
    lit = elements.panels, elements.first, elements.segments, geometry.walls
    return geometry, elements, exchange_matrix(*lit)


@pytest.mark.parametrize("albedo", [0.1, 0.5, 0.9])
def test_walls_of_a_closed_room_receive_the_light_over_and_over(albedo):
    scene = closed_room(albedo)
    light = Analytic().irradiance(scene)
    lengths = np.hypot(*(light.stops - light.starts).T)
    assert lengths @ light.irradiance == pytest.approx(2 / (1 - albedo), rel=1e-12)


@pytest.mark.parametrize("albedo", [0.3, 0.9])
def test_walls_that_emit_and_reflect_alike_make_a_furnace(albedo):
    """Uniform emission E: radiosity E / (1 - ρ) everywhere, whatever stands in the room."""
    _, elements, exchange = furnace(albedo)
    shares = np.full((len(elements.segments), 1), albedo)
    emission = 2.0
    direct = emission * elements.lengths[:, None] / shares
    radiosity = solve_radiosity(exchange, elements.lengths, shares, direct)
    np.testing.assert_allclose(radiosity, emission / (1 - albedo), rtol=1e-12)


def test_radiance_in_a_furnace_is_the_same_in_every_direction():
    geometry, elements, _ = furnace(0.5)
    bounced = Bounced(elements, np.full((len(elements.segments), 1), 4.0))
    moments = bounced.arriving(geometry.cell_outlines(), geometry.walls, 6)[:, 0]
    # L = B/2 and I = L (|cos θ| + |sin θ|): integrals of cos(mθ) are 8 / (1 - m²) for m = 4k.
    expected = np.zeros(11)
    expected[[0, 7]] = 2 * np.array([8, -8 / 15])
    empty = moments.reshape(8, 8, 11)[:4].reshape(-1, 11)
    np.testing.assert_allclose(empty, np.tile(expected, (32, 1)), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("element", [0.3, 1.0, 50.0])
@pytest.mark.parametrize("spacing", [1.0, 0.25])
def test_books_close_at_any_element(element, spacing):
    point = {**CELL, "direction": [1.0, 0.3]}
    scene = make_scene(albedo=0.8, points=[point], beams=[((0.6, -0.8), 1.5)], spacing=spacing)
    ledger = Analytic(element=element).energy(scene)
    dark = Analytic(bounces=False).energy(scene)
    assert abs(ledger.closure) < ROUNDING
    assert ledger.emitted == pytest.approx(7 + 1.5 * 8 * 1.4 * spacing)
    assert ledger.absorbed < 0.75 * dark.absorbed


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_random_scenes_balance(seed, step):
    scene = random_scene(seed, step=step, albedo=0.7, beams=[((-0.8, 0.6), 1.0), ((1, 0), 0.5)])
    assert abs(Analytic(element=2.0).energy(scene).closure) < 10 * ROUNDING


def test_a_wall_absorbs_what_it_does_not_reflect():
    """One wall in the open: nothing comes back to it."""
    dark, bright = (make_scene(walls=WALLS[:1], albedo=albedo) for albedo in (0.0, 0.7))
    absorbed = Analytic().absorbed(bright)
    np.testing.assert_allclose(absorbed, 0.3 * Analytic().absorbed(dark), rtol=1e-13)


def test_a_lit_wall_shines_like_a_light_of_the_reflected_flux():
    """Far from the lamp the wall is lit evenly, but for a gradient that small elements follow."""
    wall = ((3, 1), (3, 2))
    scene = make_scene(lights=(), walls=[wall], points=[{**CELL, "cell": [0, 1]}], albedo=1.0)
    dark = Analytic(bounces=False)
    reflected = 2 * np.arctan(0.5 / 2.5) / np.pi
    light = make_scene(lights=[(*wall, reflected)], walls=())
    bounced = Analytic(element=0.05).solve(scene, 5).values - dark.solve(scene, 5).values
    np.testing.assert_allclose(bounced, dark.solve(light, 5).values, rtol=0, atol=0.01 * reflected)


@pytest.mark.parametrize(
    "scene",
    [
        closed_room(0.8),
        make_scene(albedo=0.8),
        make_scene(lights=(), albedo=0.8, beams=[((0.6, -0.8), 1.0)]),
    ],
    ids=["lamp in a room", "area lights", "parallel light"],
)
def test_the_field_converges_with_the_second_power_of_the_element(scene):
    elements = np.array([2.0, 1.0, 0.5, 0.25])
    fields = [Analytic(element=each).solve(scene, 4).values for each in (*elements, 0.0625)]
    norm = np.linalg.norm(fields[-1])
    errors = [np.linalg.norm(field - fields[-1]) / norm for field in fields[:-1]]
    order = np.polyfit(np.log(elements), np.log(errors), 1)[0]
    assert 1.6 < order < 2.6, errors
    assert errors[2] < 3e-3, errors


def test_the_error_is_about_a_third_more_than_the_change():
    scene = closed_room(0.8)
    exact = Analytic(element=0.0625).solve(scene, 3).values
    error = np.linalg.norm(Analytic().solve(scene, 3).values - exact) / np.linalg.norm(exact)
    assert Analytic().bounce_error(scene, 3) * 4 / 3 == pytest.approx(error, rel=0.15)


def test_without_albedo_nothing_bounces_bit_for_bit(monkeypatch):
    bright, dark = make_scene(albedo=0.5), make_scene()
    asked = Analytic(bounces=False).solve(bright, 4).values
    monkeypatch.setattr("propagators.analytic.flat.bounce", None)
    np.testing.assert_array_equal(Analytic().solve(dark, 4).values, asked)
    assert Analytic().bounce_error(dark, 4) == 0
    assert Analytic().energy(dark).absorbed == Analytic(bounces=False).energy(bright).absorbed


def test_walls_that_no_light_reaches_are_left_out():
    dark_corner = outline((1, 1), (3, 1), (2, 3))
    geometry = read_geometry(make_scene(lights=(), walls=dark_corner, points=[CELL], albedo=0.5))
    # Of the triangle, the lamp lights two sides from outside; they do not see one another.
    np.testing.assert_array_equal(np.sort(bounce(geometry, 100.0).elements.surfaces), [1, 2])


def test_bright_walls_without_light_stay_dark():
    scene = make_scene(lights=(), albedo=0.5)
    assert not Analytic().solve(scene, 2).values.any()
    assert not Analytic().irradiance(scene).irradiance.any()
    assert Analytic().energy(scene).absorbed == 0


def test_colours_bounce_apart():
    def scene(albedo, flux):
        data = make_scene(points=[{**CELL, "flux": flux}]).to_dict()
        for wall, share in zip(data["occluder"], albedo):
            wall["albedo"] = share
        for light in data["light"][:-1]:
            light["flux"] = flux
        return Scene.from_dict(data)

    albedo = np.array([[0.8, 0.1, 0.0], [0.0, 0.9, 0.0], [0.5, 0.5, 0.0], [0.2, 0.3, 0.0]])
    flux = [3.0, 1.0, 2.0]
    coloured = Analytic().solve(scene(albedo.tolist(), flux), 3).values
    books = Analytic().energy(scene(albedo.tolist(), flux))
    np.testing.assert_allclose(books.closure, 0, atol=ROUNDING)
    for k, one in enumerate(coloured):
        grey = scene(albedo[:, k].tolist(), flux[k])
        np.testing.assert_allclose(one, Analytic().solve(grey, 3).values, rtol=0, atol=1e-13)


def test_the_sum_over_directions_converges_to_the_coefficients():
    """Beams in space against strings in angle: nothing shared but the radiosity."""
    scene, count = make_scene(albedo=0.8), 4096
    angles = (np.arange(count) + 0.5) * (2 * np.pi / count)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    weights = CircularHarmonics(6).evaluate(directions).T * (2 * np.pi / count)
    values = np.tensordot(weights, Analytic().intensity(scene, directions), 1)
    exact = Analytic().solve(scene, 6).values
    assert np.linalg.norm(values - exact) < 2e-5 * np.linalg.norm(exact)


def test_arcs_of_walls_name_their_segment():
    scene = make_scene(lights=LIGHTS[:1], walls=WALLS[:1], albedo=0.5, spacing=0.5)
    arcs = Analytic().arcs(scene, (1.4, 1.3))
    assert {arc.emitter for arc in arcs} == {0, -1}
    assert all(arc.radiance > 0 for arc in arcs)


def test_a_closed_room_that_absorbs_nothing_has_no_answer():
    with pytest.raises(ConvergenceError, match="albedo must be below 1"):
        Analytic().solve(closed_room(1.0), 1)


def test_a_white_room_around_a_black_light_has_an_answer():
    scene = make_scene(walls=room(), albedo=1.0)
    ledger = Analytic().energy(scene)
    assert ledger.absorbed == pytest.approx(5, abs=1e-10)
    np.testing.assert_array_equal(Analytic().absorbed(scene), 0)
