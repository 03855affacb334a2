"""What many steps of the real engine do to light, beside what theory says."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from typing import ClassVar

import numpy as np

from flatland.errors import InstabilityError, SchemeWarning
from flatland.scene import Scene
from flatland.simulation import PRECISIONS, Simulation
from propagators import Option, StencilPropagator
from studies.kinds.base import (
    SCHEME_COLUMNS,
    Column,
    Kind,
    Point,
    Row,
    scheme_of,
    scheme_parameters,
    scheme_row,
)
from studies.kinds.radius import SYMBOL_AXES
from studies.kinds.starts import STARTS, start_scene
from studies.sweeps.case import Case

#: Stops per decade of steps.
_STOPS = (1, 2, 5)


class Growth(Kind):
    """One row per stop, at 1, 2, 5, 10, 20, 50 … steps, up to `steps`.

    growth is measured on a finite grid with open borders, so that it lies below the spectral
    radius, which speaks of an endless one: by what leaks out over the border, less the larger the
    grid. A run that grows wild ends with its last good state.
    """

    name = "growth"
    summary = "norm of the light over many steps of the engine, in either precision"
    on_scenes = False
    axes = (
        *SYMBOL_AXES,
        Option("start", str, "random", "what light there is at first", tuple(STARTS)),
        Option("side", int, 16, "cells along each axis", minimum=1),
        Option("steps", int, 1000, "steps in all", minimum=1),
        Option("precision", str, "float64", "of the stepped fields", PRECISIONS),
    )
    columns: ClassVar = {
        "dimension": Column(int, "of the grid"),
        **SCHEME_COLUMNS,
        "start": Column(str, "what light there was at first"),
        "side": Column(int, "cells along each axis"),
        "precision": Column(str, "of the stepped fields"),
        "iterations": Column(int, "steps done"),
        "norm": Column(float, "L2 norm of the newest light over that of the first"),
        "growth": Column(float, "factor a step since the last stop, its geometric mean"),
        "radius": Column(float, "spectral radius of the (linear) scheme"),
        "wild": Column(bool, "whether the run was stopped because light grew wild"),
        "finite": Column(bool, "whether every number of the state is finite"),
        "closure": Column(float, "what the flux ledger misses, over its largest entry"),
        "command": Column(str, "what computes the row again"),
    }

    def cases(self, point: Point) -> Iterable[Case]:
        values = point.values
        fits = values["dimension"] in point.propagator.dimensions
        flat_only = values["start"] == "mirrors" and values["dimension"] != 2
        if fits and not flat_only and isinstance(point.propagator, StencilPropagator):
            yield Case(self.name, {**scheme_parameters(point.propagator), **values})

    def describe(self, case: Case) -> Row:
        kept = ("dimension", "start", "side", "precision")
        return {**scheme_row(case.parameters), **{name: case.parameters[name] for name in kept}}

    def rows(self, case: Case, references: str) -> Iterator[Row]:
        values = case.parameters
        simulation = _simulation(case)
        radius = simulation.stencil.spectral_radius()
        simulation.inject()
        first = before = _norm(simulation)
        reached = 0
        for stop in stops_up_to(values["steps"]):
            wild = not _ran(simulation, stop)
            norm, steps = _norm(simulation), simulation.iteration - reached
            yield {
                "iterations": simulation.iteration,
                "norm": norm / first,
                "growth": _rate(before, norm, steps),
                "radius": radius,
                "wild": wild,
                "finite": bool(np.all(np.isfinite(simulation.accumulated.values))),
                "closure": _closure(simulation),
                "command": _command(case, simulation.iteration),
            }
            if wild:
                return
            before, reached = norm, simulation.iteration


def stops_up_to(steps: int) -> list[int]:
    """1, 2, 5, 10, … and the last one."""
    decades = range(len(str(steps)))
    stops = [first * 10**decade for decade in decades for first in _STOPS]
    return [*(stop for stop in stops if stop < steps), steps]


def _simulation(case: Case) -> Simulation:
    values = case.parameters
    scheme = scheme_of(values)
    assert isinstance(scheme, StencilPropagator)
    scene = Scene.from_dict(start_scene(values["start"], values["dimension"], values["side"]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SchemeWarning)  # unstable schemes are what this is about
        return Simulation(scene, scheme, values["bands"], precision=values["precision"])


def _ran(simulation: Simulation, stop: int) -> bool:
    """Whether the run came to its stop."""
    try:
        simulation.run(stop - simulation.iteration)
    except InstabilityError:
        return False
    return True


def _norm(simulation: Simulation) -> float:
    values = np.asarray(simulation.target.values, float)
    largest = float(np.abs(values).max(initial=0.0))  # squares of tiny light would vanish
    return largest * float(np.linalg.norm(values / largest)) if largest > 0 else 0.0


def _rate(before: float, after: float, steps: int) -> float:
    """NaN when nothing is left, or was there."""
    if steps < 1 or before <= 0 or after <= 0:
        return float("nan")
    return float(np.exp((np.log(after) - np.log(before)) / steps))


def _closure(simulation: Simulation) -> float:
    entries = {name: float(value) for name, value in simulation.ledger.as_dict().items()}
    missing = abs(entries.pop("closure"))
    return missing / max(map(abs, entries.values()))


def _command(case: Case, steps: int) -> str:
    values = case.parameters
    keys = ("bands", "dimension", "side", "precision")
    words = [f"--set {key}={values[key]}" for key in keys]
    from studies.kinds.schemes import scheme_text

    scheme = scheme_text(scheme_of(values))
    words += [f"--set start={values['start']}", f"--set propagators={scheme}"]
    return f"flatland study growth {' '.join(words)} --set steps={steps}"
