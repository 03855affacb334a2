"""Converged fields of scenes, and what a simulation does after one."""

import numpy as np
import pytest
from scenes import FLUX, LPV, after, assert_same_state, coloured, scene_of

from flatland.errors import ConvergenceError
from flatland.simulation import Simulation


def test_converged_field_is_where_stepping_leads():
    solved = Simulation(scene_of(), LPV, bands=3)
    solved.solve(1e-12)
    stepped = after(scene_of(), 600, bands=3)
    np.testing.assert_allclose(
        solved.accumulated.values, stepped.accumulated.values, atol=1e-9 * FLUX
    )
    assert not solved.target.values.any()


def test_books_of_a_converged_run_are_closed():
    simulation = Simulation(scene_of(), LPV)
    simulation.solve(1e-12)
    ledger = simulation.ledger
    assert ledger.inside == 0
    assert ledger.left == pytest.approx(FLUX, rel=1e-10)
    assert abs(ledger.closure) < 1e-10


def test_stepping_after_a_solve_starts_afresh():
    simulation = Simulation(scene_of(), LPV)
    simulation.solve()
    simulation.run(3)
    assert_same_state(simulation, after(scene_of(), 3))


def test_stepping_after_a_failed_solve_starts_afresh():
    """The answer that was kept is no state to step from."""
    simulation = Simulation(scene_of(), LPV)
    with pytest.raises(ConvergenceError):
        simulation.solve(1e-17, "krylov")
    assert simulation.accumulated.values.any()
    simulation.run(3)
    assert_same_state(simulation, after(scene_of(), 3))


def test_solve_takes_colours_together():
    spectra = [1.0, 2.0, 0.5], [0.0, 1.0, 4.0]
    simulation = Simulation(scene_of(coloured(*spectra)), LPV)
    simulation.solve(1e-10)
    for colour, fluxes in enumerate(zip(*spectra)):
        mono = Simulation(scene_of(coloured(*fluxes)), LPV)
        mono.solve(1e-10)
        np.testing.assert_allclose(
            simulation.accumulated.values[colour], mono.accumulated.values, atol=1e-8
        )


def test_propagator_solves_a_scene_by_itself():
    simulation = Simulation(scene_of(), LPV, bands=3)
    simulation.solve(1e-10)
    field = LPV.solve(scene_of(), bands=3, tolerance=1e-10)
    np.testing.assert_array_equal(field.values, simulation.accumulated.values)
