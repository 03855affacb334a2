"""One method on one scene: the same for every command, study and window."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.ledger import Ledger
from flatland.memory import PeakMemory
from flatland.octree import require_width
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.skipped import Skip
from propagators import Propagator, StencilPropagator

Progress = Callable[[int], object]


@dataclass(frozen=True)
class Method:
    """What to do with a scene.

    Stops after `iterations` steps, or at the converged field to the relative residual `converge`;
    with neither, after twice the longest side of the grid (Kaplanyan & Dachsbacher 2010, 3.3).
    blocking, strength, bounces, lights_block: what walls do, see `Simulation`; methods that do not
    step have their own way with walls. levels, normalization, level_factors, falloff, index and
    patience: of an octree, see `Simulation`; blend: of its merge. Methods that do not step have
    one level, on the processor. drop: light that is too little to be stepped on; device: what steps
    it, see `Simulation`.
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
    levels: int = 1
    normalization: str = "flux"
    level_factors: tuple[float, ...] | None = None
    falloff: str = "cells"
    index: str = "finest"
    patience: float = 1.0
    blend: float | None = None
    drop: float = 0.0
    device: str = "cpu"

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
            **(self._level_values if self.levels > 1 else {}),
            **({"drop": self.drop} if self.drop else {}),
            **({"device": self.device} if self.device != "cpu" else {}),
        }

    @property
    def _level_values(self) -> dict[str, Any]:
        factors = self.level_factors
        return {
            "levels": self.levels,
            "normalization": self.normalization,
            "level_factors": None if factors is None else list(factors),
            "falloff": self.falloff,
            "index": self.index,
            "patience": self.patience,
            "blend": self.blend,
        }

    def simulation(self, scene: Scene) -> Simulation:
        """A simulation that is ready to start. Raises InputError for methods that do not step."""
        if not isinstance(self.propagator, StencilPropagator):
            raise bad_input("propagator", self.propagator.name, "does not step")
        require_width(self.blend)
        return Simulation(
            scene,
            self.propagator,
            bands=self.bands,
            levels=self.levels,
            precision=self.precision,
            blocking=self.blocking,
            strength=self.strength,
            bounces=self.bounces,
            lights_block=self.lights_block,
            normalization=self.normalization,
            level_factors=self.level_factors,
            falloff=self.falloff,
            index=self.index,
            patience=self.patience,
            drop=self.drop,
            device=self.device,
        )


@dataclass(frozen=True)
class LevelResult:
    """What came of one level: its accumulated light, its ledger, and what it was injected with.

    factor: on the mean of level 0's light. read: cells of level 0 that the merge took from it.
    """

    accumulated: Field
    ledger: Ledger
    factor: float
    read: int


@dataclass(frozen=True)
class MemoryUse:
    """Bytes. fields: source, target and accumulated light. peak: all that setting up and running
    took beyond what the process had before, None where the system does not tell."""

    fields: int
    peak: int | None


@dataclass(frozen=True)
class Run:
    """What came of it. seconds: stepping or solving, and merging, without reading and compiling.

    accumulated: of an octree, the merged field. ledger: of level 0. levels: all levels if they
    were asked for, and index, (*shape), the level that each cell was read from. skips: what was
    left out since nothing needs it. memory: what it took.
    """

    method: Method
    accumulated: Field
    seconds: float
    stopped: str
    ledger: Ledger | None = None
    details: dict[str, Any] = field(default_factory=dict)
    levels: tuple[LevelResult, ...] = ()
    index: NDArray[np.int8] | None = None
    skips: tuple[Skip, ...] = ()
    memory: MemoryUse | None = None


def run_method(
    scene: Scene, method: Method, progress: Progress | None = None, keep_levels: bool = False
) -> Run:
    """Run a method on a scene. Raises what the simulation and its solvers raise.

    keep_levels: give every level of an octree beside the merged field; levels that the merge did
    not need are then propagated too, after the clock has stopped.
    """
    if not isinstance(method.propagator, StencilPropagator):
        return _answer(scene, method)
    peak = PeakMemory()
    simulation = method.simulation(scene)
    simulation.start()
    simulation.octree.prepare()
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
    memory = MemoryUse(simulation.field_bytes, peak.taken)
    if method.device != "cpu":
        details["device"] = simulation.device.name
    if method.levels == 1:
        accumulated, index = simulation.accumulated, None
    else:
        begin = time.perf_counter()
        accumulated, index = simulation.merge(method.blend), simulation.index
        seconds += time.perf_counter() - begin
    skips = tuple(simulation.explain())
    levels = _levels(simulation, index) if keep_levels and index is not None else ()
    ledger = simulation.ledger
    return Run(method, accumulated, seconds, stopped, ledger, details, levels, index, skips, memory)


def _levels(simulation: Simulation, index: NDArray[np.int8]) -> tuple[LevelResult, ...]:
    views = [simulation.level(number) for number in range(simulation.levels)]
    return tuple(
        LevelResult(view.accumulated, view.ledger, factor, int(np.count_nonzero(index == number)))
        for number, (view, factor) in enumerate(zip(views, simulation.octree.factors))
    )


def _answer(scene: Scene, method: Method) -> Run:
    if method.levels != 1:
        rule = f"must be 1: {method.propagator.name} does not step"
        raise bad_input("levels", method.levels, rule)
    if method.device != "cpu":
        rule = f"must be cpu: {method.propagator.name} does not step"
        raise bad_input("device", method.device, rule)
    begin = time.perf_counter()
    answer = method.propagator.answer(scene, method.bands)
    seconds = time.perf_counter() - begin
    reached = [f"{name} {value:g}" for name, value in answer.details.items()]
    stopped = ", ".join(["direct", *reached])
    return Run(method, answer.field, seconds, stopped, answer.ledger, answer.details)
