"""Modified discrete ordinates: exact without bounces, and with them as wrong as the stencil."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene, random_scene, room
from montecarlo import first_hits, lambertian
from tabulated import error, exact

from flatland import load_scene
from flatland.errors import InputError
from flatland.scene import Scene
from propagators.analytic import Analytic
from propagators.modified_dom import ModifiedDiscreteOrdinates, _glow
from propagators.transport.problem import read_problem


def modified(scheme="dom8", **options):
    return ModifiedDiscreteOrdinates(scheme=scheme, **options)


@pytest.mark.parametrize("scheme", ["dom8", "lpv"])
@pytest.mark.parametrize("seed", range(3))
def test_black_walls_leave_the_reference(scheme, seed):
    for scene in (make_scene(), random_scene(seed, step=0.5), load_scene("checkerboard")):
        answer = modified(scheme).answer(scene, 4)
        np.testing.assert_array_equal(answer.field.values, exact(scene, 4))
        books = Analytic().energy(scene)
        assert answer.ledger.left == pytest.approx(books.left, abs=1e-12)
        assert abs(answer.ledger.closure) < 1e-11


def test_without_bounces_walls_are_black():
    values = modified(bounces=False).solve(make_scene(albedo=0.7), 3).values
    np.testing.assert_array_equal(values, exact(make_scene(), 3))


@pytest.mark.parametrize("scheme", ["dom4", "dom8", "lpv"])
def test_error_is_the_reflected_share_times_that_of_the_stencil(scheme):
    scene = make_scene((16, 16), *doubled(), albedo=0.5)
    direct, reference = Analytic(bounces=False).solve(scene, 4).values, exact(scene, 4)
    share = error(direct, reference)
    values = modified(scheme).solve(scene, 4).values
    alone = error(values - direct, reference - direct)
    assert error(values, reference) == pytest.approx(share * alone, rel=1e-9)
    assert 0.1 < share < 0.3
    assert 0.3 < alone < 1.1


def doubled():
    lights = [(2 * np.array(a), 2 * np.array(b), flux) for a, b, flux in LIGHTS]
    return lights, [(2 * np.array(a), 2 * np.array(b)) for a, b in WALLS]


def test_it_beats_its_stencil():
    from propagators import create

    scene = load_scene("cornell-2d")
    reference = exact(scene, 2)
    for scheme in ("dom8", "dom4", "lpv"):
        alone = error(create(scheme).solve(scene, 2).values, reference)
        assert error(modified(scheme).solve(scene, 2).values, reference) < 0.6 * alone


def test_first_bounce_flux_is_that_of_photons():
    rng, count = np.random.default_rng(11), 400_000
    surfaces = np.array([light[:2] for light in LIGHTS] + list(WALLS), float)
    share = 0.0
    for start, stop, flux in LIGHTS:
        extent = np.subtract(stop, start)
        origins = np.array(start) + rng.random((count, 1)) * extent
        _, hit = first_hits(origins, lambertian(extent, rng, count), surfaces)
        share += 0.5 * flux * np.mean(hit >= len(LIGHTS))
    glow, lost = _glow(read_problem(make_scene(albedo=0.5), 1, 0.5, True))
    assert glow.sum() * np.sqrt(2 * np.pi) + lost[0] == pytest.approx(share, rel=0.005)


@pytest.mark.parametrize("scheme", ["dom8", "lpv"])
def test_books_close(scheme):
    lights = [(*LIGHTS[0][:2], [3.0, 1.0]), (*LIGHTS[1][:2], [0.0, 2.0])]
    for scene in (
        make_scene(albedo=0.6),
        make_scene(lights=lights, albedo=[0.3, 0.8]),
        make_scene(walls=room(), albedo=0.5),
    ):
        ledger = modified(scheme).answer(scene, 2).ledger
        np.testing.assert_allclose(ledger.closure, 0, atol=1e-12)
        np.testing.assert_allclose(ledger.emitted, Analytic().energy(scene).emitted, rtol=1e-12)
        assert np.all(np.abs(ledger.inside) < 1e-8)
        assert np.all(ledger.reflected > 0)


def test_what_starts_outside_the_grid_has_left():
    """A wall that is lit from the border glows back half a cell in front of it: outside."""
    lamp = {"kind": "point", "position": [0.1, 4.0], "flux": 1.0}
    scene = make_scene(lights=(), points=[lamp], walls=[((0.3, 1.0), (0.3, 7.0))], albedo=0.5)
    _, lost = _glow(read_problem(scene, 1, 0.5, True))
    assert lost[0] > 0.2
    ledger = modified().answer(scene, 1).ledger
    assert abs(ledger.closure) < 1e-12
    assert ledger.left > Analytic(bounces=False).energy(scene).left + lost[0] - 1e-12


def test_colours_are_solved_one_by_one():
    lights = [((1.2, 1.1), (3.9, 1.7), [3.0, 1.0])]
    both = modified().solve(make_scene(lights=lights, albedo=[0.5, 0.9]), 3).values
    for k, albedo in enumerate((0.5, 0.9)):
        one = make_scene(lights=[(*lights[0][:2], lights[0][2][k])], albedo=albedo)
        np.testing.assert_allclose(both[k], modified().solve(one, 3).values, rtol=0, atol=1e-8)


@pytest.mark.parametrize("scheme", ["analytic", "beam", "dom26", "modified-dom"])
def test_what_does_not_step_in_two_dimensions_is_refused(scheme):
    with pytest.raises(
        InputError, match=f"scheme = '{scheme}': does not step in 2D; accepted: lpv"
    ):
        modified(scheme).solve(make_scene(), 2)


def test_an_unknown_scheme_is_refused():
    with pytest.raises(InputError, match="propagator = 'dom9': is unknown"):
        modified("dom9").solve(make_scene(), 2)


def test_three_dimensions_are_refused():
    with pytest.raises(InputError, match="dimension"):
        modified().solve(Scene.from_dict({"grid": {"shape": [2, 2, 2]}}), 2)
