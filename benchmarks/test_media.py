"""A medium: what it costs a stencil, and the lattice method beside it."""

from __future__ import annotations

import warnings

import pytest
from conftest import best_seconds

import propagators
from flatland import Scene, Simulation
from flatland.errors import SchemeWarning

_SIDE = 64


def _scene(extinction: float) -> Scene:
    light = {"kind": "area", "start": [12.0, 4.0], "end": [22.0, 4.0], "flux": 5.0}
    medium = {"extinction": extinction, "albedo": 0.9}
    return Scene.from_dict({"grid": {"shape": [_SIDE] * 2}, "light": [light], "medium": medium})


@pytest.mark.parametrize("name", ["dom8", "lpv"])
def test_steps_in_a_medium(name, report):
    """Collisions that stay in their cell are a second pass over the grid."""
    seconds = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SchemeWarning)
        for extinction in (0.0, 0.5):
            run = Simulation(_scene(extinction), propagators.create(name), bands=4)

            def steps(run=run) -> None:  # type: ignore[no-untyped-def]
                run.inject()
                run.run(64)

            seconds[extinction] = best_seconds(steps, 5)
    ratio = seconds[0.5] / seconds[0.0]
    report(f"{name} {_SIDE}², 64 steps in a medium: {ratio:.1f} x those in a vacuum")
    assert ratio < 200


def test_lattice_boltzmann(report):
    scene = _scene(0.5)
    lattice = propagators.create("lattice-boltzmann")
    seconds = best_seconds(lambda: lattice.solve(scene, 4), 3)
    simulation = Simulation(scene, propagators.create("dom8"), bands=4)
    dom8 = best_seconds(lambda: simulation.solve(1e-8), 2)
    report(f"lattice-boltzmann {_SIDE}² converged: {seconds:.2f} s; dom8 {dom8:.2f} s")
    assert seconds < 60
