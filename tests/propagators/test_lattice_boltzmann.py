"""Lattice-Boltzmann lighting: a lattice that conserves, diffuses and spreads light as it should."""

import numpy as np
import pytest
from alike import mirrored, mirrored_scene, turned, turned_scene
from analytic_scenes import LIGHTS, make_scene, room
from tabulated import error, exact, one_light

from flatland.errors import ConvergenceError, InputError, SchemeWarning
from flatland.harmonics import CircularHarmonics
from flatland.moments import exact_moments
from flatland.scene import Scene
from propagators.lattice_boltzmann import LatticeBoltzmann
from propagators.lattice_boltzmann.rules import (
    PROBABILITIES,
    THICKEST,
    VELOCITIES,
    WEIGHTS,
    arc_values,
    collision_matrix,
    diffusion_coefficient,
    lattice_moments,
    step_probability,
)

OPTICAL = (0.1, 0.25, 0.5, 1.0)


def in_medium(scene, extinction, albedo):
    return Scene.from_dict(
        {**scene.to_dict(), "medium": {"extinction": extinction, "albedo": albedo}}
    )


def test_weights_are_isotropic_to_fourth_order():
    assert WEIGHTS.sum() == pytest.approx(1, abs=1e-15)
    x, y = VELOCITIES.T
    assert WEIGHTS @ x**2 == pytest.approx(3 / 5)
    assert WEIGHTS @ (x * y) == pytest.approx(0)
    # Σ w x⁴ = 3 Σ w x² y² for an isotropic tensor.
    assert WEIGHTS @ x**4 == pytest.approx(3 * (WEIGHTS @ (x**2 * y**2)))


@pytest.mark.parametrize(("scattered", "absorbed"), [(0.1, 0.0), (0.3, 0.2), (0.5, 0.5), (0, 1)])
def test_published_columns_sum_to_one(scattered, absorbed):
    matrix = collision_matrix(scattered, absorbed, True)
    np.testing.assert_allclose(matrix.sum(axis=0), 1, rtol=1e-15)
    assert np.all(matrix >= 0)
    lost = collision_matrix(scattered, absorbed, False).sum(axis=0)
    np.testing.assert_allclose(lost, [0, *8 * [1]], atol=1e-15)


def test_diffusion_coefficients():
    for share, expected in ((0.1, 5.7), (0.5, 0.9), (1.0, 0.3)):
        for direction in (0.0, 0.4, np.pi / 4, np.pi / 2):
            assert diffusion_coefficient(share, direction=direction) == pytest.approx(
                expected, rel=2e-5
            )
    # Rest slows diffusion: a share of the photons stands.
    assert diffusion_coefficient(0.3, 0.2) == pytest.approx(0.6 * (1 / 0.5 - 0.5) / 1.2, rel=1e-5)


def test_absorbing_and_emitting_again_neither_grows_nor_fades():
    matrix = collision_matrix(0.3, 0.2, True)
    axis = np.linspace(-np.pi, np.pi, 41)
    waves = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    steps = matrix * np.exp(-1j * (waves @ VELOCITIES.T))[:, None, :]
    assert np.abs(np.linalg.eigvals(steps)).max() == pytest.approx(1, abs=1e-12)


def test_probabilities():
    found = [step_probability(x) for x in OPTICAL]
    np.testing.assert_allclose(found, [0.1066, 0.2558, 0.4778, 0.8358], atol=5e-5)
    for p, x in zip(found, OPTICAL):
        assert 6 / 5 * (2 - p) / p**2 == pytest.approx(2 / x**2, rel=1e-12)
    assert step_probability(THICKEST) == pytest.approx(1, abs=1e-12)
    assert step_probability(0.0) == 0
    assert step_probability(1e-200) == pytest.approx(np.sqrt(1.2) * 1e-200, rel=1e-12)


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.9])
def test_calibrated_light_spreads_over_the_exact_mean_square(albedo):
    for x in OPTICAL:
        found, truth = lattice_moments(x, albedo), exact_moments(x, albedo)
        assert found.m0 == pytest.approx(truth.m0, rel=1e-12)
        assert found.r2 == pytest.approx(truth.r2, rel=1e-9)


@pytest.mark.parametrize(
    ("rule", "albedo", "second", "fourth"),
    [
        ("calibrated", 0.9, (1, 1, 1, 1), (1.007, 0.994, 0.970, 0.918)),
        ("calibrated", 0.0, (1, 1, 1, 1), (1.050, 0.955, 0.790, 0.425)),
        ("linear", 0.9, (1.140, 1.050, 0.900, 0.600), (1.310, 1.096, 0.784, 0.318)),
        ("exponential", 0.9, (1.262, 1.363, 1.557, 2.054), (1.606, 1.853, 2.373, 4.009)),
    ],
)
def test_moments_as_tabulated(rule, albedo, second, fourth):
    for x, r2, r4 in zip(OPTICAL, second, fourth):
        found, truth = lattice_moments(x, albedo, rule), exact_moments(x, albedo)
        assert found.r2 / truth.r2 == pytest.approx(r2, abs=6e-4)
        assert found.r4 / truth.r4 == pytest.approx(r4, abs=6e-4)


def test_arcs_tile_the_circle_and_isotropic_light_is_the_equilibrium():
    arcs = arc_values(CircularHarmonics(3))
    np.testing.assert_allclose(arcs.sum(axis=0), [np.sqrt(2 * np.pi), 0, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(arcs[:, 0] / np.sqrt(2 * np.pi), WEIGHTS[1:], rtol=1e-14)


def test_errors_in_a_vacuum_are_those_tabulated():
    for bands, expected in ((2, 0.927), (4, 0.942), (8, 0.957)):
        values = LatticeBoltzmann().solve(one_light(), bands).values
        assert error(values, exact(one_light(), bands)) == pytest.approx(expected, abs=1.5e-3)


@pytest.mark.parametrize("absorbed", ["lost", "reemit"])
@pytest.mark.parametrize(("extinction", "albedo"), [(0.0, 0.0), (0.05, 0.9), (0.9, 0.99), (1, 0)])
def test_books_close(absorbed, extinction, albedo):
    lights = [(*LIGHTS[0][:2], [3.0, 1.0]), (*LIGHTS[1][:2], [0.0, 2.0])]
    for scene in (
        make_scene(albedo=0.6),
        make_scene(lights=lights, albedo=[0.3, 0.8]),
        make_scene(walls=()),
    ):
        ledger = (
            LatticeBoltzmann(absorbed=absorbed)
            .answer(in_medium(scene, extinction, albedo), 2)
            .ledger
        )
        np.testing.assert_allclose(ledger.closure, 0, atol=1e-12)
        assert np.all(np.abs(ledger.inside) < 1e-9)
        kept = absorbed == "lost" and extinction > 0
        assert np.all((ledger.medium > 1e-3) == kept)


def test_reemitted_light_is_scattered_light_in_the_end():
    """A rest of one step changes when light leaves, not where to."""
    scattering = LatticeBoltzmann().solve(in_medium(make_scene(), 0.5, 1.0), 3).values
    published = LatticeBoltzmann(absorbed="reemit").solve(in_medium(make_scene(), 0.5, 0.3), 3)
    np.testing.assert_allclose(published.values, scattering, rtol=0, atol=1e-9)


def test_an_endless_medium_holds_what_its_moments_say():
    """A pulse in the middle of a grid that light hardly leaves."""
    lights = [{"kind": "cell", "cell": [30, 30], "flux": 1.0}]
    tables = {"grid": {"shape": [61, 61]}, "light": lights}
    scene = in_medium(Scene.from_dict(tables), 1.0, 0.5)
    answer = LatticeBoltzmann().answer(scene, 1)
    assert answer.ledger.left < 1e-6
    assert answer.ledger.medium == pytest.approx(1, abs=1e-6)
    # All that left cells: light of m0 collisions, each after 1/p steps.
    total = answer.field.total_flux()
    assert total == pytest.approx(2 / step_probability(1.0), rel=1e-6)


def test_mirrored_and_turned_scenes_have_mirrored_and_turned_answers():
    values = LatticeBoltzmann().solve(in_medium(make_scene(), 0.3, 0.8), 4).values
    for scene, expected in (
        (mirrored_scene(), mirrored(values)),
        (turned_scene(), turned(values)),
    ):
        found = LatticeBoltzmann().solve(in_medium(scene, 0.3, 0.8), 4).values
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_too_thick_a_medium_is_refused():
    with pytest.raises(InputError, match=r"= 1.3: is too thick for this lattice: at most 1.291"):
        LatticeBoltzmann().solve(in_medium(make_scene(), 1.3, 0.5), 2)
    with pytest.raises(InputError, match=r"is too thick for this lattice: at most 1.291"):
        LatticeBoltzmann().solve(in_medium(make_scene(), 1e9, 0.5), 2)
    with pytest.raises(InputError, match="at most 1.000 collisions a cell"):
        LatticeBoltzmann(probability="linear").solve(in_medium(make_scene(), 1.1, 0.5), 2)


@pytest.mark.parametrize("rule", PROBABILITIES[1:])
def test_other_probabilities_warn_with_the_number(rule):
    with pytest.warns(SchemeWarning, match=r"spreads light over \d+\.\d% of the mean square"):
        LatticeBoltzmann(probability=rule).solve(in_medium(make_scene(), 0.5, 0.5), 1)


def test_light_without_a_way_out_never_settles():
    scene = make_scene(
        lights=(), walls=room(), albedo=1.0, points=[{"kind": "cell", "cell": [2, 3], "flux": 1.0}]
    )
    with pytest.raises(ConvergenceError, match="did not settle"):
        LatticeBoltzmann().solve(in_medium(scene, 0.5, 1.0), 1)


def test_a_solver_that_breaks_down_is_begun_anew():
    """What one wall sends back along a row: BiCGSTAB's first product is zero there."""
    lights = [{"kind": "cell", "cell": [i, 0], "flux": 0.01} for i in (0, 4)]
    wall = {"kind": "segment", "start": [0.0, 0.0], "end": [0.0, 0.25], "albedo": 0.5}
    scene = Scene.from_dict({"grid": {"shape": [5, 1]}, "light": lights, "occluder": [wall]})
    books = LatticeBoltzmann().answer(scene, 1).ledger
    assert books.emitted == pytest.approx(0.02)
    assert abs(books.closure) < 1e-12 * books.emitted
