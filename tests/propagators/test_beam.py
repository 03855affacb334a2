"""Exact beams: no error in space, second order in angle, books that close."""

import warnings

import numpy as np
import pytest
from alike import SAME, mirrored, mirrored_scene, turned, turned_scene
from analytic_scenes import make_scene, random_scene
from tabulated import clutter, error, exact, one_light
from test_analytic_energy import DEGENERATE
from test_analytic_known import BOX

import propagators
from flatland import load_scene
from flatland.errors import InputError, SchemeWarning
from flatland.scene import Scene, builtin_names
from propagators.analytic import Analytic
from propagators.analytic.geometry import read_geometry
from propagators.beam import Beam, propagator
from propagators.beam.flight import Transport
from propagators.transport.arrangement import arrange
from propagators.transport.ordinates import Ordinates
from propagators.transport.surface_elements import cut_elements

ROUNDING = 1e-12
#: Cells; what is nearer touches, for the reference too.
TOUCH = 1e-8
AXES = [[1, 0], [0, 1], [-1, 0], [0, -1]]


def beam(ordinates=0, **options):
    return Beam(ordinates=ordinates, **options)


def random_directions(count=12):
    angles = np.random.default_rng(5).uniform(0, 2 * np.pi, count)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def area_scenes():
    """Built-in flat scenes with lights of some length and black walls."""
    scenes = {name: load_scene(name) for name in builtin_names()}
    return {
        name: scene
        for name, scene in scenes.items()
        if scene.grid.dimension == 2 and any(light.kind == "area" for light in scene.lights)
    }


AREA_SCENES = area_scenes()


def test_one_ordinate_cell_by_cell():
    direction = np.full((1, 2), np.sqrt(0.5))
    intensity = beam().intensity(one_light(), direction)[0]
    half = np.sqrt(0.5) / 2
    row = [0, half, 2 * half, 2 * half, 2 * half, 2 * half, half, 0]
    np.testing.assert_allclose(intensity[5:13, 1], row, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(intensity[6:14, 2], row, rtol=0, atol=ROUNDING)
    assert not np.any(intensity[:, 0])


def test_closed_box_of_uniform_radiance():
    """c0 is exact, as emission is; the rest is 1.07 times what unscaled emission leaves there."""
    scene = make_scene(lights=BOX, walls=())
    for count, tabulated in ((64, 1.84e-3), (256, 1.13e-4)):
        values = beam(count).solve(scene, 8).values
        np.testing.assert_allclose(values[0], 8 / np.sqrt(2 * np.pi), rtol=1e-14)
        # The same in border cells as in the middle.
        np.testing.assert_allclose(values, values[:, 3:4, 3:4] + 0 * values, rtol=0, atol=1e-13)
        ordinates = Ordinates(count)
        plain = beam().intensity(scene, ordinates.directions)
        unscaled = np.einsum(
            "mk,mij->kij", ordinates.harmonics(Beam()._problem(scene, 8).basis), plain
        )
        assert np.abs(unscaled - exact(scene, 8)).max() == pytest.approx(tabulated, rel=5e-3)
        assert np.abs(values - exact(scene, 8)).max() < 1.1 * tabulated


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(8))
def test_every_direction_is_that_of_the_reference(seed, step):
    """Two codes that share no geometry but the reading of the scene."""
    scene = random_scene(seed, step=step, lights=3, walls=12)
    directions = np.concatenate([random_directions(), AXES])
    found = beam().intensity(scene, directions)
    np.testing.assert_allclose(found, Analytic().intensity(scene, directions), rtol=0, atol=TOUCH)


@pytest.mark.parametrize("name", DEGENERATE)
def test_lines_that_touch_cross_or_lie_on_one_another(name):
    lights, walls = DEGENERATE[name]
    scene = make_scene(lights=lights, walls=walls)
    found = beam().intensity(scene, random_directions())
    reference = Analytic().intensity(scene, random_directions())
    # A light of 1e-6 cells has a radiance of 1e6.
    atol = TOUCH * max(1.0, np.abs(read_geometry(scene).radiance).max() / 10)
    np.testing.assert_allclose(found, reference, rtol=0, atol=atol)
    ledger = beam(64).answer(scene, 1).ledger
    assert abs(ledger.closure) < ROUNDING
    assert ledger.emitted == pytest.approx(sum(flux for *_, flux in lights), rel=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_the_books_of_every_few_ordinates_close(seed):
    surfaces = cut_elements(arrange(read_geometry(random_scene(seed, lights=3, walls=12))), 1.0)
    for offset in np.linspace(0, 1, 9):
        flight = Transport(surfaces, Ordinates(4, offset), (8, 8)).fly(surfaces.radiance, None)
        missing = flight.emitted - flight.left - flight.arrived.sum(axis=(0, 1))
        assert abs(missing[0]) < ROUNDING


@pytest.mark.parametrize("name", SAME)
def test_other_descriptions_of_a_scene_have_its_answer(name):
    values = beam(64).solve(make_scene(), 6).values
    np.testing.assert_allclose(
        beam(64).solve(SAME[name](), 6).values, values, rtol=0, atol=ROUNDING
    )


def test_mirrored_and_turned_scenes_have_mirrored_and_turned_answers():
    values = beam(64).solve(make_scene(), 6).values
    for scene, expected in (
        (mirrored_scene(), mirrored(values)),
        (turned_scene(), turned(values)),
    ):
        found = beam(64).solve(scene, 6).values
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    ("scene", "count", "tabulated"),
    [
        (one_light, 64, (0.045, 0.051, 0.062)),
        (one_light, 128, (0.0071, 0.0081, 0.0097)),
        (one_light, 512, (5.5e-4, 6.3e-4, 7.4e-4)),
        (clutter, 64, (0.041, 0.054, 0.073)),
        (clutter, 256, (0.0045, 0.0059, 0.0080)),
        (clutter, 1024, (2.9e-4, 3.8e-4, 5.1e-4)),
    ],
)
def test_errors_are_those_tabulated(scene, count, tabulated):
    made = scene()
    for bands, expected in zip((2, 4, 8), tabulated):
        found = error(beam(count).solve(made, bands).values, exact(made, bands))
        assert found == pytest.approx(expected, rel=0.02), bands


def test_second_order_in_the_number_of_ordinates():
    scene, counts = make_scene(), np.array([256, 512, 1024, 2048, 4096])
    reference = exact(scene, 8)
    errors = [error(beam(int(count)).solve(scene, 8).values, reference) for count in counts]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert 1.85 < order < 2.15, (order, errors)
    assert errors[-1] < 2e-6, errors


@pytest.mark.parametrize("name", AREA_SCENES)
def test_one_percent_by_default_and_a_thousandth_at_16_a_cell(name):
    scene = AREA_SCENES[name]
    reference = exact(scene, 8)
    assert error(beam().solve(scene, 8).values, reference) < 0.01
    fine = beam(16 * max(scene.grid.shape)).solve(scene, 8).values
    assert error(fine, reference) < 0.001


@pytest.mark.parametrize("name", ["shelf", "corridor", "clutter"])
def test_dark_cells_are_exactly_dark(name):
    reference = exact(AREA_SCENES[name], 4)
    dark = np.all(np.abs(reference) <= 1e-12 * np.abs(reference).max(), axis=0)
    assert np.any(dark)
    values = beam(128).solve(AREA_SCENES[name], 4).values
    assert not np.any(values[:, dark])
    assert np.all(values[0, ~dark & (reference[0] > 1e-2 * reference[0].max())] > 0)


def test_refinement_meets_the_tolerance_and_says_what_it_reached():
    for scene in (one_light(), load_scene("corridor")):
        reference = exact(scene, 4)
        for tolerance in (1e-2, 1e-3, 1e-4):
            answer = beam(64, tolerance=tolerance).answer(scene, 4)
            assert answer.details["error"] <= tolerance
            assert 0.3 < error(answer.field.values, reference) / answer.details["error"] < 1
            assert abs(answer.ledger.closure) < ROUNDING


def test_refinement_that_falls_short_warns(monkeypatch):
    monkeypatch.setattr(propagator, "MOST_ORDINATES", 128)
    with pytest.warns(SchemeWarning, match=r"reached an error of .* with 128 ordinates"):
        beam(64, tolerance=1e-9).solve(one_light(), 2)


def test_both_together_are_twice_as_many_ordinates():
    """Without scale, offsets 0 and 1/2 of M are offset 0 of 2M."""
    scene = make_scene()
    halves = [Ordinates(64, offset).directions for offset in (0, 0.5)]
    both = beam().intensity(scene, np.concatenate(halves)).sum(axis=0)
    whole = beam().intensity(scene, Ordinates(128, 0).directions).sum(axis=0)
    np.testing.assert_allclose(both, whole, rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", ["two-walls", "back-bleeding", "checkerboard"])
def test_points_are_those_of_the_reference(name):
    scene = load_scene(name)
    np.testing.assert_array_equal(beam().solve(scene, 4).values, exact(scene, 4))
    assert abs(beam().answer(scene, 1).ledger.closure) < 1e-11


def test_one_thread_or_two(monkeypatch):
    scene = make_scene((20, 30), albedo=0.3)
    values = {}
    for count in (1, 2):
        monkeypatch.setenv("FLATLAND_THREADS", str(count))
        values[count] = beam(128).solve(scene, 3).values
    np.testing.assert_allclose(values[1], values[2], rtol=0, atol=1e-12)


def test_no_light_is_no_field():
    for walls in ((), [((1, 1), (5, 5))]):
        assert not np.any(beam().solve(make_scene(lights=(), walls=walls), 3).values)


@pytest.mark.parametrize(
    ("options", "bands", "rule"),
    [
        ({"ordinates": 66}, 2, "ordinates = 66: must be a multiple of 4"),
        ({"ordinates": 12}, 4, "ordinates = 12: must be at least 16, 4 for each of 4 bands"),
    ],
)
def test_bad_ordinates_are_refused(options, bands, rule):
    with pytest.raises(InputError, match=rule):
        propagators.create("beam", **options).solve(make_scene(), bands)


def test_three_dimensions_are_refused():
    with pytest.raises(InputError, match="dimension"):
        beam().solve(Scene.from_dict({"grid": {"shape": [2, 2, 2]}}), 2)


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.5, 0.9])
@pytest.mark.parametrize("count", [4, 12, 64])
def test_scaled_emission_is_exact_in_sum(count, offset):
    ordinates = Ordinates(count, offset)
    turns = np.array([0.0, 0.3, np.pi / 2, 2.0, -1.2])
    ways = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    segments = np.hstack([np.zeros((5, 2)), 3 * ways])
    normals = np.stack([-ways[:, 1], ways[:, 0]], axis=-1)
    plain = ordinates.weight * np.maximum(0, ordinates.directions @ normals.T).sum(axis=0)
    np.testing.assert_allclose(plain * ordinates.emission_scale(segments), 2, rtol=1e-13)


@pytest.mark.slow
def test_beams_and_strings_meet():
    """Exact in space and summed in angle against exact in angle: 1e-7 apart at 16,384."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for scene in (one_light(), make_scene()):
            assert error(beam(16384).solve(scene, 8).values, exact(scene, 8)) < 1e-6
