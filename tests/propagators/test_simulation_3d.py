"""Whole runs in three dimensions: against plain arrays, with books, and to convergence."""

import numpy as np
import pytest
from scenes import lobe_scene, scene_of
from stepping import operator, plain_run

import propagators
from flatland.injection import inject
from flatland.simulation import Simulation

#: Rounding of sums over a thousand cells.
ROUNDING = 1e-12
LIGHTS = [
    {"kind": "cell", "cell": [2, 3, 1], "direction": [1.0, 0.4, -0.3], "flux": 2.0},
    {"kind": "cell", "cell": [5, 0, 6], "flux": 1.0},
    {"kind": "wall", "side": "left", "flux": 3.0},
]
SHAPE = (7, 5, 9)
NAMES = ["lpv", "lpv-2009", "dom6", "dom26"]
#: Applications of the operator that multigrid takes to 1e-8, at most.
APPLICATIONS = 80


def simulation_of(name, bands=2, scene=None, precision="float64", **options):
    scene = scene or scene_of(LIGHTS, SHAPE)
    propagator = propagators.create(name, **options)
    return Simulation(scene, propagator, bands=bands, precision=precision)


@pytest.mark.parametrize("bands", [1, 3])
@pytest.mark.parametrize("name", NAMES)
def test_run_is_what_plain_steps_give(name, bands):
    simulation = simulation_of(name, bands)
    simulation.run(6)
    start = inject(simulation.scene, simulation.basis).values
    states, _ = plain_run(simulation.stencil, start, 6)
    found = simulation.target.values, simulation.accumulated.values
    for values, expected in zip(found, (states[-1], sum(states))):
        np.testing.assert_allclose(values, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 3, 5])
@pytest.mark.parametrize(
    ("name", "options"), [*((name, {}) for name in NAMES), ("lpv", {"clamp": True})]
)
def test_books_close(name, options, bands):
    """Light is emitted, leaves or is inside; a clamp alone creates some."""
    simulation = simulation_of(name, bands, **options)
    simulation.run(20)
    ledger = simulation.ledger
    assert ledger.emitted == pytest.approx(6.0, rel=1e-14)
    assert abs(ledger.closure) < ROUNDING
    assert ledger.left > 0.5
    assert ledger.inside == pytest.approx(simulation.target.total_flux(), abs=ROUNDING)
    conserves = not options and (name != "lpv-2009" or bands < 5)
    assert (abs(ledger.created) < ROUNDING) == (conserves or bands == 1)


@pytest.mark.parametrize("name", NAMES)
def test_single_precision_is_near(name):
    double, single = (simulation_of(name, 3, precision=p) for p in ("float64", "float32"))
    for simulation in (double, single):
        simulation.run(12)
    assert single.accumulated.values.dtype == np.float32
    error = np.abs(single.accumulated.values - double.accumulated.values).max()
    assert error < 1e-5 * np.abs(double.accumulated.values).max()


def test_light_of_an_axial_scheme_reaches_as_many_cells_as_steps():
    simulation = simulation_of("lpv", scene=lobe_scene((11, 11, 11)))
    simulation.run(3)
    steps = np.abs(np.indices((11, 11, 11)) - 5).sum(axis=0)
    lit = simulation.accumulated.values[0] != 0
    np.testing.assert_array_equal(lit, steps <= 3)


@pytest.mark.parametrize("name", NAMES)
def test_converged_field_solves_the_equation(name):
    """(1 − A) S_A = S_0, with A written as a sparse matrix."""
    simulation = simulation_of(name)
    report = simulation.solve(1e-10)
    start = inject(simulation.scene, simulation.basis).values.ravel()
    answer = simulation.accumulated.values.ravel()
    defect = start - answer + operator(simulation.stencil, SHAPE) @ answer
    assert np.linalg.norm(defect) <= 1e-10 * np.linalg.norm(start)
    assert report.residual <= 1e-10


def test_converged_field_is_where_stepping_leads():
    solved, stepped = simulation_of("lpv"), simulation_of("lpv")
    solved.solve(1e-11)
    stepped.run(400)
    expected = stepped.accumulated.values
    np.testing.assert_allclose(solved.accumulated.values, expected, atol=1e-9)


@pytest.mark.parametrize(("side", "bands"), [(15, 2), (16, 2), (32, 2), (16, 3)])
def test_multigrid_takes_as_few_applications_on_any_grid(side, bands):
    simulation = simulation_of("lpv", bands, lobe_scene((side,) * 3))
    report = simulation.solve(1e-8, "multigrid")
    assert report.method == "multigrid"
    assert report.applications <= APPLICATIONS, report


def test_multigrid_takes_grids_of_unequal_sides():
    report = simulation_of("lpv", scene=lobe_scene((5, 17, 24))).solve(1e-8, "multigrid")
    assert report.applications <= APPLICATIONS, report
