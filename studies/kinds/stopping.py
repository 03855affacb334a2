"""What a case of kind `errors` may be told, and where it stops."""

from __future__ import annotations

import re
from typing import Any

from flatland.errors import bad_input
from flatland.occlusion import BLOCKING
from flatland.simulation import PRECISIONS
from propagators import Option, StencilPropagator
from studies.kinds.base import Point

#: Iterations without any given: twice the longest side (Kaplanyan & Dachsbacher 2010, 3.3).
HEURISTIC = "2N"

AXES = (
    Option("resolution", int, 1, "cells per cell of the scene, along each axis", minimum=1),
    Option("bands", int, 2, "angular bands", minimum=1),
    Option("precision", str, "float64", "of the stepped fields", PRECISIONS),
    Option("blocking", str, "exact", "what walls do", BLOCKING),
    Option("strength", float, 1.0, "factor on fuzzy blocking", minimum=0.0),
    Option("bounces", bool, True, "whether walls send light back"),
    Option("lights_block", bool, False, "whether area lights are walls for other light"),
    Option("converge", float, 0.0, "relative residual of the converged field; 0: not wanted"),
    Option("reference", bool, True, "whether to measure against the exact answer"),
    Option("repeats", int, 0, "how often to time the run; 0: once, beside others", minimum=0),
)


def stops_of(point: Point, longest: int) -> list[dict[str, Any]]:
    """What the cases of a point end with: their iterations, their residual, or neither."""
    if not isinstance(point.propagator, StencilPropagator):
        return [{"iterations": [], "converge": 0.0}]
    tolerance, wanted = point.values["converge"], point.values.get("iterations")
    if not 0 <= tolerance < 1:
        raise bad_input("converge", tolerance, "must lie between 0 and 1")
    if wanted is None and not tolerance:
        wanted = [HEURISTIC]
    found = [] if wanted is None else [{"iterations": _counted(wanted, longest), "converge": 0.0}]
    return [*found, {"iterations": [], "converge": tolerance}] if tolerance else found


def _counted(wanted: list[Any], longest: int) -> list[int]:
    """Numbers of steps, ascending. Raises InputError."""
    return sorted({_count(entry, longest) for entry in wanted})


def _count(entry: Any, longest: int) -> int:
    if isinstance(entry, int) and not isinstance(entry, bool) and entry >= 0:
        return entry
    match = re.fullmatch(r"(\d*\.?\d*)N", entry) if isinstance(entry, str) else None
    if match is None:
        rule = "must be whole numbers, at least 0, or multiples of the longest side as in 2N"
        raise bad_input("iterations", entry, rule)
    return round(float(match[1] or 1) * longest)


def without_effects(parameters: dict[str, Any], point: Point) -> dict[str, Any]:
    """Settings that change nothing at their default, so that equal cases are one case."""
    assert point.scene is not None
    plain = {axis.name: axis.default for axis in AXES}
    walls = ("blocking", "strength", "bounces", "lights_block")
    idle: tuple[str, ...] = ()
    if not isinstance(point.propagator, StencilPropagator):
        idle = ("precision", *walls)
    elif not point.scene.tables.get("occluder") and not parameters["lights_block"]:
        idle = walls
    elif parameters["blocking"] != "fuzzy":
        idle = ("strength",)
    return {**parameters, **{name: plain[name] for name in idle}}
