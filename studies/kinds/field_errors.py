"""A method on a scene, and how wrong its field is: the kind most studies are made of."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from flatland.errors import FlatlandError
from flatland.field import Field
from flatland.ledger import Ledger
from flatland.simulation import Simulation
from propagators import StencilPropagator
from studies.comparison import measure
from studies.kinds.base import (
    Kind,
    Point,
    Row,
    scheme_of,
    scheme_parameters,
    scheme_row,
)
from studies.kinds.commands import command_of
from studies.kinds.field_columns import COLUMNS
from studies.kinds.stopping import AXES, stops_of, without_effects
from studies.kinds.timing import Stopwatch, Timing
from studies.metrics import band_errors
from studies.running import Method
from studies.sweeps.case import Case
from studies.sweeps.references import shared_reference

#: By how much rounding may put an error under the floor.
FLOOR_TOLERANCE = 1e-9


class FloorBeatenError(FlatlandError, ArithmeticError):
    """An error is smaller than the least that is possible: a fault in a scheme or a measure."""


class FieldErrors(Kind):
    """One row per stop: after each number of `iterations`, or the converged field.

    `iterations` holds whole numbers, or multiples of the longest side N as "2N" (the paper's
    heuristic, and the default); they are stops of one run. `converge` asks for the converged field
    to that relative residual. `repeats` > 0 makes the case a timed one: after a run that is not
    counted it is done so often, one case at a time on the whole machine.
    """

    name = "errors"
    summary = "a method on a scene, its errors against the exact answer, its books and its time"
    axes = AXES
    lists = ("iterations",)
    columns = COLUMNS

    def cases(self, point: Point) -> Iterable[Case]:
        assert point.scene is not None
        grid = point.scene.load().grid
        if grid.dimension not in point.propagator.dimensions:
            return
        values = {k: v for k, v in point.values.items() if k not in ("resolution", "iterations")}
        parameters = {**scheme_parameters(point.propagator), **values}
        timed = values["repeats"] > 0
        for stop in stops_of(point, max(grid.shape)):
            same = without_effects({**parameters, **stop}, point)
            yield Case(self.name, same, point.scene, timed)

    def describe(self, case: Case) -> Row:
        assert case.scene is not None
        parameters, grid = case.parameters, case.scene.load().grid
        kept = ("precision", "blocking", "strength", "bounces", "lights_block")
        return {
            "scene": case.scene.name,
            "scene_digest": case.scene.digest[:12],
            "dimension": grid.dimension,
            "resolution": case.scene.resolution,
            "cells": max(grid.shape),
            "spacing": grid.spacing,
            **scheme_row(parameters),
            **{name: parameters[name] for name in kept},
            "repeats": parameters["repeats"],
        }

    def rows(self, case: Case, references: str) -> Iterator[Row]:
        assert case.scene is not None
        meter = _Meter(case, references)
        method = method_of(case)
        if not isinstance(method.propagator, StencilPropagator):
            yield _direct(case, method, meter)
        elif method.converge is not None:
            yield _converged(case, method, meter)
        else:
            yield from _stepped(case, method, meter)


def method_of(case: Case) -> Method:
    """The method of a case, up to its last stop."""
    values = case.parameters
    stops = values["iterations"]
    return Method(
        scheme_of(values),
        values["bands"],
        stops[-1] if stops else None,
        values["converge"] or None,
        values["precision"],
        values["blocking"],
        values["strength"],
        values["bounces"],
        values["lights_block"],
    )


@dataclass(frozen=True)
class _Meter:
    """Turns a field and its books into columns."""

    case: Case
    references: str

    def row(self, field: Field, ledger: Ledger | None) -> Row:
        return {**self._errors(field), **_books(ledger)}

    def _errors(self, field: Field) -> Row:
        values, scene = self.case.parameters, self.case.scene
        if not values["reference"]:
            return {}
        assert scene is not None
        bands = values["bands"]
        reference = shared_reference(scene, values["bounces"], bands, self.references)
        errors = measure(field, reference)
        if errors["angular"] < errors["floor"] - FLOOR_TOLERANCE:
            message = (
                f"the error over all directions is {errors['angular']:.12g}, below the floor of "
                f"{errors['floor']:.12g} for {bands} bands: a measure or a scheme is wrong"
            )
            raise FloorBeatenError(message)
        return {**errors, "band_errors": band_errors(field, reference.field(bands))}


def _books(ledger: Ledger | None) -> Row:
    if ledger is None:
        return {}
    sums = {name: float(np.sum(value)) for name, value in ledger.as_dict().items()}
    drift = sums["created"] / sums["emitted"] if sums["emitted"] else 0.0
    return {**sums, "drift": drift}


def _direct(case: Case, method: Method, meter: _Meter) -> Row:
    assert case.scene is not None
    scene, watch = case.scene.load(), Stopwatch(case.parameters["repeats"])
    field, timing = watch.measure(lambda: method.propagator.solve(scene, method.bands))
    command = command_of(case)
    return {"stop": "direct", **meter.row(field, None), **timing.as_row(), "command": command}


def _converged(case: Case, method: Method, meter: _Meter) -> Row:
    simulation, setup = _simulation(case, method)
    watch = Stopwatch(case.parameters["repeats"])
    assert method.converge is not None
    tolerance = method.converge
    report, timing = watch.measure(lambda: simulation.solve(tolerance))
    return {
        "stop": "converged",
        "converge": tolerance,
        "residual": report.residual,
        "solver": report.method,
        "applications": report.applications,
        **meter.row(simulation.accumulated, simulation.ledger),
        **timing.as_row(),
        "setup_seconds": setup,
        "command": command_of(case),
    }


def _stepped(case: Case, method: Method, meter: _Meter) -> Iterator[Row]:
    simulation, setup = _simulation(case, method)
    stops = case.parameters["iterations"]
    for stop, timing in _timed_stops(simulation, stops, case.parameters["repeats"]):
        yield {
            "stop": "steps",
            "iterations": stop,
            "heuristic": stop == 2 * max(simulation.scene.grid.shape),
            **meter.row(simulation.accumulated, simulation.ledger),
            **timing.as_row(),
            "setup_seconds": setup,
            "command": command_of(case, stop),
        }


def _timed_stops(
    simulation: Simulation, stops: list[int], repeats: int
) -> Iterator[tuple[int, Timing]]:
    """The stops of one run, each with the time from the start to it; measuring does not count.

    Timed runs come first, and the last run is the one that is looked at.
    """
    laps = [_laps(simulation, stops) for _ in range(repeats + 1)] if repeats else []
    simulation.inject()
    spent = 0.0
    for place, stop in enumerate(stops):
        begin = time.perf_counter()
        simulation.run(stop - simulation.iteration)
        spent += time.perf_counter() - begin
        times = [lap[place] for lap in laps]
        yield stop, Timing.of(times[1:], times[0]) if times else Timing.of([spent])


def _laps(simulation: Simulation, stops: list[int]) -> list[float]:
    """Seconds from the start to each stop."""
    simulation.inject()
    begin, laps = time.perf_counter(), []
    for stop in stops:
        simulation.run(stop - simulation.iteration)
        laps.append(time.perf_counter() - begin)
    return laps


def _simulation(case: Case, method: Method) -> tuple[Simulation, float]:
    assert case.scene is not None
    begin = time.perf_counter()
    simulation = method.simulation(case.scene.load())
    return simulation, time.perf_counter() - begin
