"""Light propagation maps: exact flux and places, an error that falls with angles and rays."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene, random_scene, room
from montecarlo import share_that_leaves
from tabulated import clutter, error, exact, one_light
from test_analytic_known import BOX

from flatland import load_scene
from flatland.errors import ConvergenceError, SchemeWarning
from flatland.injection import inject
from flatland.scene import Scene
from propagators.analytic import Analytic
from propagators.maps import LightPropagationMaps

FLUX = 1e-11


def maps(angles=32, rays=8, **options):
    return LightPropagationMaps(angles=angles, rays=rays, **options)


def tripled(albedo=0.0):
    """Two slanted lights and four walls on 24 x 24 cells, much like the table's scene A."""
    lights = [(3 * np.array(a), 3 * np.array(b), flux) for a, b, flux in LIGHTS]
    walls = [(3 * np.array(a), 3 * np.array(b)) for a, b in WALLS]
    return make_scene((24, 24), lights, walls, albedo=albedo)


@pytest.mark.parametrize(
    ("scene", "angles", "rays", "tabulated"),
    [
        (one_light, 4, 2, (0.445, 0.508, 0.595)),
        (one_light, 8, 4, (0.154, 0.179, 0.220)),
        (one_light, 16, 4, (0.057, 0.065, 0.078)),
        (one_light, 32, 8, (0.0151, 0.0177, 0.0208)),
        (one_light, 64, 16, (0.0053, 0.0063, 0.0075)),
        (tripled, 32, 8, (0.0077, 0.0109, 0.0158)),
        (tripled, 64, 16, (0.0033, 0.0041, 0.0057)),
    ],
)
def test_errors_are_those_tabulated(scene, angles, rays, tabulated):
    made = scene()
    values, reference = maps(angles, rays).solve(made, 8).values, exact(made, 8)
    for bands, expected in zip((2, 4, 8), tabulated):
        size = 2 * bands - 1
        found = error(values[:size], reference[:size])
        # The walls of scene A were not handed down; these are as long and as many.
        assert found == pytest.approx(expected, rel=0.06 if scene is one_light else 0.2), bands


def test_error_falls_with_rays_and_angles():
    reference = exact(tripled(), 8)
    coarse = error(maps(64, 2).solve(tripled(), 8).values, reference)
    fine = error(maps(64, 8).solve(tripled(), 8).values, reference)
    assert 2.5 < coarse / fine < 6
    few = error(maps(8, 16).solve(tripled(), 8).values, reference)
    many = error(maps(32, 16).solve(tripled(), 8).values, reference)
    assert few / many > 4


@pytest.mark.parametrize("albedo", [0.0, 0.5])
def test_books_close_and_all_flux_is_sent(albedo):
    scenes = [tripled(albedo), clutter(), *(random_scene(k, step=0.5) for k in range(4))]
    for scene in scenes:
        ledger = maps(8, 4).answer(scene, 1).ledger
        assert abs(ledger.closure) < FLUX
        assert ledger.created == 0
        assert ledger.emitted == pytest.approx(Analytic().energy(scene).emitted, rel=1e-12)


def test_flux_that_leaves_is_that_of_photons_with_bounces():
    share, deviation = share_that_leaves(LIGHTS, WALLS, 0.5, 1_000_000, 3)
    left = maps(64, 16).answer(make_scene(albedo=0.5), 1).ledger.left / 5
    assert deviation < 5e-4
    assert left == pytest.approx(share, abs=0.001 * share + 3 * deviation)
    # The exact answer is as near to the photons.
    exact_left = Analytic().energy(make_scene(albedo=0.5)).left / 5
    assert exact_left == pytest.approx(share, abs=3.5 * deviation)
    assert left == pytest.approx(exact_left, rel=1.5e-3)


@pytest.mark.slow
def test_flux_that_leaves_is_that_of_photons_to_a_thousandth():
    share, deviation = share_that_leaves(LIGHTS, WALLS, 0.5, 30_000_000, 4)
    assert deviation < 1e-4
    left = maps(128, 32).answer(make_scene(albedo=0.5), 1).ledger.left / 5
    assert left == pytest.approx(share, rel=0.001)


def test_bounces_are_as_good_as_first_flight():
    scene = tripled(0.5)
    assert error(maps().solve(scene, 2).values, exact(scene, 2)) < 0.01
    assert error(exact(tripled(), 2), exact(scene, 2)) > 0.1


def test_light_in_a_closed_white_room_never_ends():
    cell = {"kind": "cell", "cell": [2, 3], "flux": 1.0}
    scene = make_scene(lights=(), walls=room(), albedo=1.0, points=[cell])
    with pytest.raises(ConvergenceError, match="albedo must be below 1"):
        maps(8, 2).solve(scene, 1)


def test_a_box_of_uniform_radiance_is_nearly_uniform():
    values = maps().solve(make_scene(lights=BOX, walls=()), 4).values
    np.testing.assert_allclose(values[0], 8 / np.sqrt(2 * np.pi), rtol=0.01)
    assert np.abs(values - exact(make_scene(lights=BOX, walls=()), 4)).max() < 0.05


def test_dark_cells_are_exactly_dark():
    """Rays are exact: what no light reaches in any direction is not lit."""
    for name in ("shelf", "corridor"):
        reference = exact(load_scene(name), 2)
        dark = np.all(np.abs(reference) <= 1e-12 * np.abs(reference).max(), axis=0)
        assert np.any(dark)
        assert not np.any(maps(16, 4).solve(load_scene(name), 2).values[:, dark])


def test_light_in_cells_is_spread_over_them():
    """What an injector puts into cells depends on the bands."""
    for bands, expected in zip((2, 4, 8), (0.145, 0.124, 0.141)):
        values = maps(source="cell").solve(one_light(), bands).values
        assert error(values, exact(one_light(), bands)) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(
    "light",
    [
        {"kind": "cell", "cell": [2, 3], "direction": [1.0, 0.4], "flux": 2.0},
        {"kind": "wall", "side": "left", "flux": 3.0},
        {"kind": "area", "start": [3.1, 4.0], "end": [5.7, 4.9], "flux": 1.5},
        {"kind": "point", "position": [4.2, 3.7], "flux": 2.0},
        {"kind": "directional", "direction": [1.0, -0.6], "irradiance": 0.5},
        {"kind": "environment", "radiance": 0.2},
        {"kind": "cell", "cell": [2, 3], "flux": [1.0, 2.0]},
    ],
    ids=lambda light: light["kind"],
)
def test_any_injector_sends_all_its_flux(light):
    wall = {"kind": "segment", "start": [1.0, 5.5], "end": [6.0, 6.2], "albedo": 0.4}
    scene = Scene.from_dict({"grid": {"shape": [8, 7]}, "light": [light], "occluder": [wall]})
    answer = maps(8, 4, source="cell").answer(scene, 3)
    own = light if light["kind"] not in ("point", "directional") else {**light, "inject": "direct"}
    alone = Scene.from_dict({"grid": {"shape": [8, 7]}, "light": [own], "occluder": [wall]})
    emitted = inject(alone, answer.field.basis).total_flux()
    np.testing.assert_allclose(answer.ledger.emitted, emitted, rtol=1e-12)
    np.testing.assert_allclose(answer.ledger.closure, 0, atol=FLUX)
    assert np.all(answer.ledger.absorbed > 0)
    # A cell's own light leaves it, as in a stencil.
    assert np.all(answer.field.total_flux() > answer.ledger.emitted * 0.99)


def test_lights_that_no_ray_meets_are_missed_aloud():
    tiny = make_scene(lights=[((3.0, 3.3), (3.0001, 3.3), 1.0)], walls=())
    with pytest.warns(SchemeWarning, match="of the light comes from surfaces that no ray meets"):
        ledger = maps(1, 1).answer(tiny, 1).ledger
    assert ledger.created == pytest.approx(-1)
    assert abs(ledger.closure) < FLUX


def test_colours_are_solved_one_by_one():
    lights = [((1.2, 1.1), (3.9, 1.7), [3.0, 1.0]), ((6.6, 6.8), (6.1, 4.3), [0.0, 2.0])]
    both = maps(8, 4).solve(make_scene(lights=lights, albedo=[0.5, 0.9]), 3).values
    for k, albedo in enumerate((0.5, 0.9)):
        grey = [(a, b, flux[k]) for a, b, flux in lights]
        one = maps(8, 4).solve(make_scene(lights=grey, albedo=albedo), 3).values
        np.testing.assert_allclose(both[k], one, rtol=0, atol=1e-8)


def test_one_thread_or_two(monkeypatch):
    values = {}
    for count in (1, 2):
        monkeypatch.setenv("FLATLAND_THREADS", str(count))
        values[count] = maps(16, 4).solve(make_scene((20, 30), albedo=0.3), 3).values
    np.testing.assert_allclose(values[1], values[2], rtol=0, atol=1e-9)
