"""How wrong the levels of an octree are, level by level and step by step."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, ClassVar

import xarray as xr

from flatland.octree import most_levels
from propagators import Option, Propagator, StencilPropagator
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
from studies.kinds.stopping import AXES, OF_LEVELS
from studies.level_errors import error_history
from studies.sweeps.case import Case

#: What `levels` is in the row of the merged field.
MERGED = -1
_OF_LEVELS = tuple(axis for axis in AXES if axis.name in OF_LEVELS)
_BOTH = ("coefficients", "scalar_flux", "infinity_mean", "infinity_abs")
_THESIS = ("thesis_absolute", "thesis_relative")
_WHOLE = ("printed_absolute", "printed_relative", "corrected_absolute", "corrected_relative")


class LevelHistory(Kind):
    """One row per iteration and level, and one for the merged field, whose level is -1.

    All errors are against the converged uniform grid, downsampled to the level, but for the
    thesis' own, which compare a level with the children in the same octree (numerics §7).
    """

    name = "levels"
    summary = "errors of an octree's levels and of its merged field after every iteration"
    axes = (
        Option("resolution", int, 1, "cells per cell of the scene, along each axis", minimum=1),
        Option("bands", int, 2, "angular bands", minimum=1),
        Option("levels", int, 3, "levels of the octree", minimum=2),
        *_OF_LEVELS,
        Option("steps", int, 16, "iterations", minimum=0),
    )
    columns: ClassVar = {
        "scene": Column(str, "name of the scene"),
        "scene_digest": Column(str, "fingerprint of the scene on this grid"),
        "dimension": Column(int, "of the grid"),
        "resolution": Column(int, "cells per cell of the scene, along each axis"),
        "cells": Column(int, "cells along the longest side, N"),
        **SCHEME_COLUMNS,
        "levels": Column(int, "levels of the octree"),
        **{axis.name: Column(axis.type, axis.meaning) for axis in _OF_LEVELS},
        "iterations": Column(int, "steps done"),
        "level": Column(int, "which level; -1: the merged field"),
        "coefficients": Column(float, "relative L2 of all coefficients"),
        "scalar_flux": Column(float, "relative L2 of band 0"),
        "infinity_mean": Column(float, "mean relative infinity norm"),
        "infinity_abs": Column(float, "mean absolute infinity norm"),
        "thesis_absolute": Column(float, "the thesis' mean absolute error, of this level"),
        "thesis_relative": Column(float, "the thesis' mean relative error, of this level"),
        "printed_absolute": Column(float, "the thesis' e_abs as printed, of the octree"),
        "printed_relative": Column(float, "the thesis' e_rel as printed, of the octree"),
        "corrected_absolute": Column(float, "e_abs over the elements that there are"),
        "corrected_relative": Column(float, "e_rel over the elements that there are"),
        "command": Column(str, "what computes `coefficients` again"),
    }

    def cases(self, point: Point) -> Iterable[Case]:
        assert point.scene is not None
        grid, values = point.scene.load().grid, point.values
        fits = grid.dimension in point.propagator.dimensions
        if fits and isinstance(point.propagator, StencilPropagator):
            kept = {name: value for name, value in values.items() if name != "resolution"}
            kept["levels"] = min(kept["levels"], most_levels(grid.shape))
            yield Case(self.name, {**scheme_parameters(point.propagator), **kept}, point.scene)

    def describe(self, case: Case) -> Row:
        assert case.scene is not None
        grid = case.scene.load().grid
        return {
            "scene": case.scene.name,
            "scene_digest": case.scene.digest[:12],
            "dimension": grid.dimension,
            "resolution": case.scene.resolution,
            "cells": max(grid.shape),
            **scheme_row(case.parameters),
            **{name: case.parameters[name] for name in ("levels", *OF_LEVELS)},
        }

    def rows(self, case: Case, references: str) -> Iterator[Row]:
        history = _history(case)
        for iteration in history["iteration"].values.tolist():
            moment = history.sel(iteration=iteration)
            for level in history["level"].values.tolist():
                yield {
                    "iterations": iteration,
                    "level": level,
                    **_numbers(moment.sel(level=level), _BOTH + _THESIS),
                    "command": _command(case, iteration, f".sel(level={level}).coefficients"),
                }
            yield {
                "iterations": iteration,
                "level": MERGED,
                "coefficients": float(moment["merged"]),
                **_numbers(moment, _WHOLE),
                "command": _command(case, iteration, ".merged"),
            }


def _history(case: Case) -> xr.Dataset:
    assert case.scene is not None
    values, scheme = case.parameters, scheme_of(case.parameters)
    assert isinstance(scheme, StencilPropagator)
    return error_history(
        case.scene.load(),
        scheme,
        values["bands"],
        values["levels"],
        values["steps"],
        **_rules(values),
    )


def _numbers(data: xr.Dataset, names: tuple[str, ...]) -> Row:
    found = {name: float(data[name]) for name in names if name in data}
    return {name: value for name, value in found.items() if not math.isnan(value)}


def _command(case: Case, iteration: int, chosen: str) -> str:
    """A Python command that computes the row's error of the coefficients again."""
    assert case.scene is not None
    values, scheme = case.parameters, scheme_of(case.parameters)
    options = "".join(f", {name}={value!r}" for name, value in _changed(scheme))
    rules = "".join(f", {name}={value!r}" for name, value in _rules(values).items())
    made = f"refined(load_scene({case.scene.word!r}), {case.scene.resolution})"
    sizes = f"{values['bands']}, {values['levels']}, {values['steps']}"
    call = f"error_history({made}, create({scheme.name!r}{options}), {sizes}{rules})"
    modules = "flatland.scene import load_scene, refined", "propagators import create"
    imports = "; ".join(f"from {each}" for each in modules)
    source = "from studies.level_errors import error_history"
    return (
        f'python -c "{imports}; {source}; print(float({call}.sel(iteration={iteration}){chosen}))"'
    )


def _changed(scheme: Propagator) -> list[tuple[str, Any]]:
    """Options that are not at their default."""
    return [
        (option.name, scheme.values[option.name])
        for option in scheme.options
        if scheme.values[option.name] != option.default
    ]


def _rules(values: Any) -> dict[str, Any]:
    """Settings of the octree as arguments of `error_history`."""
    rules = {name: values[name] for name in OF_LEVELS if name != "blend"}
    return {**rules, "blend": values["blend"] or None}
