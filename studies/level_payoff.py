"""Does an octree pay: seconds for an error, of an octree, the uniform grid, and `solve`.

Everything is one trial: a way to a field on level 0's cells, its error and its seconds. The
cheapest trial within an error is what a table prints. Errors are whatever the caller measures;
seconds are the shortest of several runs, for filling, propagating and merging, without reading
and compiling.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from flatland.field import Field
from flatland.injection import independent_spectra
from flatland.occlusion import Walls
from flatland.octree import most_levels, spread
from flatland.scene import Scene
from flatland.simulation import Simulation
from propagators import StencilPropagator

#: Error of a field on level 0's cells.
Measure = Callable[[Field], float]
#: Runs of which the shortest counts; on a shared machine longer ones are somebody else's work.
REPEATS = 5
#: Iterations that are tried, of grids and octrees.
STEPS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048)
PATIENCES = (1.0, 2.0, 4.0, 8.0, 16.0)


@dataclass(frozen=True)
class Trial:
    """One way to a field. way: "octree", "uniform", "coarse" or "solve"; setting: how, in words."""

    way: str
    setting: str
    error: float
    seconds: float


def seconds_of(call: Callable[[], object], repeats: int = REPEATS) -> float:
    """Shortest time of a call."""
    return _timed(lambda: None, call, repeats)


def action_seconds(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int,
    levels: int,
    iterations: int,
    repeats: int = REPEATS,
    **options: Any,
) -> dict[str, float]:
    """Seconds of every part of a frame apart, as in table 1 of the octree thesis.

    `inject_geometry` and `inject` go from the scene to level 0, `downsample_geometry` and
    `downsample` from there to the others; `propagate` is all iterations on all levels that a merge
    can read; `merge` the index volume and the merged field. With one level the parts that it has
    not are 0. options: further arguments of Simulation.
    """
    simulation = Simulation(scene, propagator, bands, levels, **options)
    simulation.start()
    simulation.octree.prepare()
    names = ("blocking", "strength", "bounces", "lights_block")
    walls = Walls(**{name: options[name] for name in names if name in options})
    result = {
        "inject_geometry": seconds_of(lambda: walls.occlusion(scene, simulation.stencil), repeats),
        "inject": seconds_of(lambda: independent_spectra(scene, simulation.basis), repeats)
        + seconds_of(simulation.inject, repeats),
        "downsample_geometry": 0.0,
        "downsample": 0.0,
        "merge": 0.0,
    }
    if levels > 1:
        result["downsample_geometry"] = seconds_of(simulation.downsample_geometry, repeats)
        result["downsample"] = seconds_of(simulation.downsample, repeats)
    result["propagate"] = _run_seconds(simulation, iterations, repeats)
    if levels > 1:
        result["merge"] = seconds_of(simulation.merge, repeats)
    return result


def uniform_trials(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int,
    measure: Measure,
    steps: Sequence[int] = STEPS,
    **options: Any,
) -> list[Trial]:
    """The uniform grid, stepped."""
    simulation = Simulation(scene, propagator, bands, **options)
    trials = []
    for count in steps:
        seconds = _run_seconds(simulation, count)
        error = measure(simulation.accumulated)
        trials.append(Trial("uniform", f"{count} steps", error, seconds))
    return trials


def solve_trials(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int,
    measure: Measure,
    tolerances: Iterable[float] = (0.3, 0.1, 0.03, 1e-2, 1e-3, 1e-4),
    **options: Any,
) -> list[Trial]:
    """The uniform grid, solved to several residuals."""
    simulation = Simulation(scene, propagator, bands, **options)
    trials = []
    for tolerance in tolerances:
        simulation.solve(tolerance)
        error = measure(simulation.accumulated)
        seconds = seconds_of(lambda goal=tolerance: simulation.solve(goal))  # type: ignore[misc]
        trials.append(Trial("solve", f"residual {tolerance:g}", error, seconds))
    return trials


def octree_trials(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int,
    measure: Measure,
    factors: Sequence[float] | None = None,
    steps: Sequence[int] = STEPS[:8],
    patiences: Sequence[float] = PATIENCES,
    blends: Sequence[float | None] = (None, 1.0),
    counts: Sequence[int] = (),
    **options: Any,
) -> list[Trial]:
    """Octrees of several numbers of levels, index patiences and merges.

    factors: of all levels, else "flux". counts: numbers of levels; all without them.
    """
    trials = []
    for levels in counts or range(2, most_levels(scene.grid.shape) + 1):
        chosen = None if factors is None else list(factors)[:levels]
        for patience in patiences:
            simulation = Simulation(
                scene, propagator, bands, levels, level_factors=chosen, patience=patience, **options
            )
            simulation.start()
            simulation.octree.prepare()
            for count in steps:
                fill = seconds_of(simulation.downsample)
                run = _run_seconds(simulation, count)
                for blend in blends:
                    merge = seconds_of(lambda: simulation.merge(blend))  # noqa: B023
                    setting = f"{levels} levels, {count} steps, patience {patience:g}"
                    setting += "" if blend is None else ", blended"
                    error = measure(simulation.merge(blend))
                    trials.append(Trial("octree", setting, error, fill + run + merge))
    return trials


def coarse_trials(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int,
    measure: Measure,
    factors: Sequence[float] | None = None,
    steps: Sequence[int] = STEPS,
    **options: Any,
) -> list[Trial]:
    """One coarse level alone, each of its cells spread over the cells of level 0."""
    levels = most_levels(scene.grid.shape)
    chosen = None if factors is None else list(factors)[:levels]
    simulation = Simulation(
        scene, propagator, bands, levels, level_factors=chosen, skip=False, **options
    )
    trials = []
    for count in steps:
        simulation.start()
        simulation.run(count)
        for number in range(1, levels):
            light = simulation.level(number).accumulated
            field = Field(scene.grid, light.basis, spread(light.values, number, scene.grid.shape))
            level = simulation.octree.levels[number]
            seconds = _timed(simulation.start, lambda: level.run(count))  # noqa: B023
            trials.append(
                Trial("coarse", f"level {number}, {count} steps", measure(field), seconds)
            )
            simulation.run(count)
    return trials


def cheapest(trials: Iterable[Trial], error: float) -> Trial | None:
    """The fastest trial within an error; None if there is none."""
    good = [trial for trial in trials if trial.error <= error]
    return min(good, key=lambda trial: trial.seconds, default=None)


def _run_seconds(simulation: Simulation, count: int, repeats: int = REPEATS) -> float:
    """Shortest time of so many iterations; the light stays after them."""
    simulation.start()
    simulation.octree.prepare()
    return _timed(simulation.start, lambda: simulation.run(count), repeats)


def _timed(
    prepare: Callable[[], object], call: Callable[[], object], repeats: int = REPEATS
) -> float:
    """Shortest time of a call, each time after another that does not count."""
    times = []
    for _ in range(repeats):
        prepare()
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)
