"""One method on one scene: the same for every command, study and window."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from flatland.errors import bad_input
from flatland.field import Field
from flatland.ledger import Ledger
from flatland.scene import Scene
from flatland.simulation import Simulation
from propagators import Propagator, StencilPropagator

Progress = Callable[[int], object]


@dataclass(frozen=True)
class Method:
    """What to do with a scene.

    Stops after `iterations` steps, or at the converged field to the relative residual `converge`;
    with neither, after twice the longest side of the grid (Kaplanyan & Dachsbacher 2010, 3.3).
    blocking, strength, bounces, lights_block: what walls do, see `Simulation`; methods that do not
    step have their own way with walls.
    """

    propagator: Propagator
    bands: int = 2
    iterations: int | None = None
    converge: float | None = None
    precision: str = "float64"
    blocking: str = "exact"
    strength: float = 1.0
    bounces: bool = True
    lights_block: bool = False

    def steps_on(self, scene: Scene) -> int:
        return 2 * max(scene.grid.shape) if self.iterations is None else self.iterations

    def as_dict(self) -> dict[str, Any]:
        """Plain values that say how to do it again."""
        return {
            "propagator": self.propagator.name,
            "options": self.propagator.values,
            "bands": self.bands,
            "iterations": self.iterations,
            "converge": self.converge,
            "precision": self.precision,
            "blocking": self.blocking,
            "strength": self.strength,
            "bounces": self.bounces,
            "lights_block": self.lights_block,
        }

    def simulation(self, scene: Scene) -> Simulation:
        """A simulation that is ready to start. Raises InputError for methods that do not step."""
        if not isinstance(self.propagator, StencilPropagator):
            raise bad_input("propagator", self.propagator.name, "does not step")
        return Simulation(
            scene,
            self.propagator,
            bands=self.bands,
            precision=self.precision,
            blocking=self.blocking,
            strength=self.strength,
            bounces=self.bounces,
            lights_block=self.lights_block,
        )


@dataclass(frozen=True)
class Run:
    """What came of it. seconds: stepping or solving alone, without reading and compiling."""

    method: Method
    accumulated: Field
    seconds: float
    stopped: str
    ledger: Ledger | None = None
    details: dict[str, Any] = field(default_factory=dict)


def run_method(scene: Scene, method: Method, progress: Progress | None = None) -> Run:
    """Run a method on a scene. Raises what the simulation and its solvers raise."""
    if not isinstance(method.propagator, StencilPropagator):
        return _answer(scene, method)
    simulation = method.simulation(scene)
    simulation.inject()
    begin = time.perf_counter()
    if method.converge is not None:
        report = simulation.solve(method.converge)
        seconds = report.seconds
        stopped = f"converged to {report.residual:.1e} by {report.method}"
        details = {"solver": report.method, "applications": report.applications}
    else:
        simulation.run(method.steps_on(scene), progress)
        seconds = time.perf_counter() - begin
        stopped = f"{simulation.iteration} iterations"
        details = {"iterations": simulation.iteration}
    return Run(method, simulation.accumulated, seconds, stopped, simulation.ledger, details)


def _answer(scene: Scene, method: Method) -> Run:
    begin = time.perf_counter()
    accumulated = method.propagator.solve(scene, method.bands)
    return Run(method, accumulated, time.perf_counter() - begin, "direct")
