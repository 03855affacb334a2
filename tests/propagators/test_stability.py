"""Von Neumann stability: known radii, warnings, and runs that grow."""

import ast
import itertools
import re
import warnings

import numpy as np
import pytest
from scenes import lobe_scene, quiet
from schemes import every_scheme, variants
from stepping import neighbours, random_stencil

import propagators
from flatland.errors import InstabilityError, SchemeWarning
from flatland.harmonics import CircularHarmonics, basis_for
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.stability import RADIUS_TOLERANCE
from flatland.stencil import Stencil

LPV_CENTRAL = ("lpv", {"flux": "central"})
LPV_TRANSFER = ("lpv", {})
DOM4_DELTA = ("dom4", {"emission": "delta"})
DOM4_BIN = ("dom4", {})
DOM8_DELTA = ("dom8", {"emission": "delta"})
DOM8_BIN = ("dom8", {})
COLUMNS = [LPV_CENTRAL, LPV_TRANSFER, DOM4_DELTA, DOM4_BIN, DOM8_DELTA, DOM8_BIN]
#: Numerics §3; 1.2732 is 4/π.
TABLE = {
    1: [1, 1, 1, 1, 1, 1],
    2: [1, 1, 1, 1, 1, 1],
    3: [1, 1, 1.2732, 1, 1, 1],
    4: [1, 1, 1.2732, 1, 1, 1],
    5: [0.9674, 1, 1.2732, 1, 1.2732, 1],
}
CASES = [
    (name, options, bands, radius)
    for bands, radii in TABLE.items()
    for (name, options), radius in zip(COLUMNS, radii)
]
#: Half a unit of the table's last digit.
FOUR_DIGITS = 5e-5


def radius_of(propagator, dimension, bands):
    return propagator.stencil(basis_for(dimension, bands)).spectral_radius()


def brute_force(stencil, count=48):
    """Largest |eigenvalue| on a fine grid of wave vectors, zone corners included."""
    axis = np.linspace(-np.pi, np.pi, count + 1)
    waves = np.array(list(itertools.product(axis, repeat=stencil.basis.dimension)))
    return np.abs(np.linalg.eigvals(stencil.symbol(waves))).max()


def warnings_of(action):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        action()
    return caught


def advised(message):
    """The propagator that a warning recommends, made from its text."""
    name, options = re.search(r"; stable: ([\w-]+)\((.*)\)$", message).groups()
    call = ast.parse(f"f({options})", mode="eval").body
    values = {keyword.arg: ast.literal_eval(keyword.value) for keyword in call.keywords}
    return propagators.create(name, **values)


UNSTABLE = [
    (propagator, dimension)
    for propagator, dimension in variants()
    if radius_of(propagator, dimension, {2: 5, 3: 3}[dimension]) > 1 + RADIUS_TOLERANCE
]
every_unstable = pytest.mark.parametrize(("propagator", "dimension"), UNSTABLE, ids=str)


@pytest.mark.parametrize(("name", "options", "bands", "radius"), CASES)
def test_known_radii(name, options, bands, radius):
    found = radius_of(propagators.create(name, **options), 2, bands)
    assert found == pytest.approx(radius, abs=FOUR_DIGITS)


@pytest.mark.parametrize(("name", "bands"), [("dom4", 3), ("dom8", 5)])
def test_delta_emission_grows_by_four_over_pi(name, bands):
    found = radius_of(propagators.create(name, emission="delta"), 2, bands)
    assert found == pytest.approx(4 / np.pi, abs=1e-9)


@every_scheme(dimensions=(2,))
def test_no_wave_grows_faster_than_the_radius(propagator, dimension):
    """And some wave grows as fast, up to what a grid of waves with steps of 0.13 misses."""
    stencil = propagator.stencil(basis_for(dimension, 4))
    sampled, radius = brute_force(stencil), stencil.spectral_radius()
    assert sampled - 1e-9 <= radius <= sampled + 0.005 * max(1.0, sampled)


@pytest.mark.parametrize("seed", range(6))
def test_radius_of_made_up_schemes(seed):
    """Waves that grow fastest lie anywhere in the zone, between the samples."""
    rng = np.random.default_rng(seed)
    stencil = random_stencil(rng, CircularHarmonics(2), neighbours(2, diagonal=seed % 2 == 0))
    sampled, radius = brute_force(stencil, 96), stencil.spectral_radius()
    assert sampled - 1e-9 <= radius <= sampled * 1.002


def test_radius_of_a_three_dimensional_scheme(rng):
    stencil = random_stencil(rng, basis_for(3, 1), neighbours(3, diagonal=False))
    assert stencil.spectral_radius() == pytest.approx(brute_force(stencil, 24), rel=0.01)


@pytest.mark.parametrize("factor", [0.0, 0.5, 2.0])
def test_radius_scales_with_the_propagation_factor(factor):
    found = radius_of(propagators.create("lpv", propagation_factor=factor), 2, 2)
    assert found == pytest.approx(factor, abs=1e-9)


def test_there_are_unstable_schemes_to_warn_of():
    assert UNSTABLE


@every_unstable
def test_unstable_scheme_warns_once_with_its_radius_and_a_stable_alternative(propagator, dimension):
    bands = {2: 5, 3: 3}[dimension]
    scene = lobe_scene((5,) * dimension)

    def run():
        simulation = Simulation(scene, propagator, bands=bands)
        simulation.run(2)
        simulation.inject()
        simulation.run(1)

    (warning,) = warnings_of(run)
    assert warning.category is SchemeWarning
    message = str(warning.message)
    assert f"{radius_of(propagator, dimension, bands):.4f}" in message
    assert repr(propagator) in message
    assert radius_of(advised(message), dimension, bands) <= 1 + RADIUS_TOLERANCE


def test_every_simulation_warns():
    scene, propagator = lobe_scene((5, 5)), propagators.create("dom4", emission="delta")
    caught = warnings_of(lambda: [Simulation(scene, propagator, bands=3) for _ in range(3)])
    assert len(caught) == 3


def test_coloured_scene_warns_once():
    lights = [
        {"kind": "cell", "cell": [1, 1], "flux": [1.0, 0.0, 0.0]},
        {"kind": "cell", "cell": [2, 3], "flux": [0.0, 1.0, 0.0]},
    ]
    scene = Scene.from_dict({"grid": {"shape": [5, 5]}, "light": lights})
    propagator = propagators.create("dom4", emission="delta")
    assert len(warnings_of(lambda: Simulation(scene, propagator, bands=3).run(3))) == 1


def test_warning_points_at_the_line_that_asked():
    scene, propagator = lobe_scene((5, 5)), propagators.create("dom4", emission="delta")
    (warning,) = warnings_of(lambda: Simulation(scene, propagator, bands=3))
    assert warning.filename == __file__


@every_scheme()
def test_stable_schemes_do_not_warn(propagator, dimension):
    """With two bands every scheme is stable."""
    assert not warnings_of(lambda: Simulation(lobe_scene((4,) * dimension), propagator, bands=2))


def test_amplified_light_is_advised_to_be_damped():
    propagator = propagators.create("lpv", propagation_factor=1.5, flux="central")
    (warning,) = warnings_of(lambda: Simulation(lobe_scene((4, 4)), propagator))
    assert advised(str(warning.message)).values == {**propagator.values, "propagation_factor": 1.0}


def test_scheme_without_stable_options_says_so():
    class Doubling(propagators.StencilPropagator):
        name = "doubling"
        summary = "doubles light at every step"

        def _build(self, basis):
            transfer = np.broadcast_to(np.eye(basis.size) / 2, (4, basis.size, basis.size))
            return Stencil(basis, neighbours(2, diagonal=False), transfer.copy())

    (warning,) = warnings_of(lambda: Simulation(lobe_scene((4, 4)), Doubling()))
    assert "2.0000" in str(warning.message)
    assert str(warning.message).endswith("no choice of options makes it stable")


def growing(precision="float64", factor=1.0):
    """DOM4 with peaks and three bands: grows by 1.27 a step and soon by more than it loses."""
    propagator = propagators.create("dom4", emission="delta", propagation_factor=factor)
    return quiet(propagator, lobe_scene((33, 33)), bands=3, precision=precision)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_growing_light_stops_the_run_with_its_state_kept(precision, factor):
    simulation = growing(precision, factor)
    with pytest.raises(InstabilityError, match="grown by a factor") as caught:
        simulation.run(3000)
    assert f"at iteration {simulation.iteration}:" in str(caught.value)
    assert 0 < simulation.iteration < 3000
    for field in (simulation.source, simulation.target, simulation.accumulated):
        assert np.all(np.isfinite(field.values))
    assert simulation.ledger.inside == pytest.approx(simulation.target.total_flux(), rel=1e-4)


def test_light_that_has_grown_wild_is_not_stepped_further():
    simulation = growing()
    with pytest.raises(InstabilityError):
        simulation.run(3000)
    iteration, values = simulation.iteration, simulation.accumulated.values
    with pytest.raises(InstabilityError):
        simulation.run(1)
    assert simulation.iteration == iteration
    np.testing.assert_array_equal(simulation.accumulated.values, values)


def test_a_run_can_start_again_after_it_grew_wild():
    simulation = growing()
    with pytest.raises(InstabilityError):
        simulation.run(3000)
    simulation.inject()
    simulation.run(5)
    assert simulation.iteration == 5


def test_stopped_run_was_the_run_that_it_would_have_been():
    """Stopping early changes nothing about the steps before."""
    simulation, short = growing(), growing()
    with pytest.raises(InstabilityError):
        simulation.run(3000)
    short.run(simulation.iteration - 1)
    np.testing.assert_array_equal(short.target.values, simulation.source.values)


@every_unstable
def test_no_stationary_answer_is_invented_for_a_growing_scheme(propagator, dimension):
    simulation = quiet(propagator, lobe_scene((5,) * dimension), bands={2: 5, 3: 3}[dimension])
    with pytest.raises(InstabilityError, match="no converged field"):
        simulation.solve()
