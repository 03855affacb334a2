"""Light of area lights on groups of panels: panels are cut until the error is small enough."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from propagators.analytic_3d.panels import PanelLight, Panels, split_panels

Array = NDArray[np.float64]

#: Share of what error is left to spend that one round of cuts may leave behind.
_SHARE = 0.5
#: Rounds after which panels are 1e-6 cells wide and kept as they are.
_MOST_ROUNDS = 20
#: Rounds in which panels are cut at planes of lights, whatever their errors.
_BLIND_ROUNDS = 3


def integrate(
    panels: Panels,
    light_of: Callable[[Panels], PanelLight],
    planes: Array,
    group_count: int,
    tolerance: float,
) -> Array:
    """Sums (groups, C, size) over panels, to a relative L2 error of all sums together.

    planes: (L, 4) of the lights. Panels that a wall may shade are cut in four at once, and those
    that a light's plane crosses along it: two rules that agree may both have missed what lies
    beyond. Then those with the largest estimated errors are cut, until the squares of all others
    sum up to at most (tolerance |sums|)². The estimate belongs to the coarser of two rules, so
    that the error is smaller still.
    """
    found = light_of(panels)
    result = np.zeros((group_count, *found.values.shape[1:]))
    np.add.at(result, panels.groups, found.values)
    budget = (tolerance * float(np.linalg.norm(result))) ** 2
    result.fill(0.0)
    for rounds in range(_MOST_ROUNDS):
        blind = (
            (found.crossed >= 0) if rounds < _BLIND_ROUNDS else np.zeros(len(found.errors), bool)
        )
        if rounds == 0:
            blind |= found.shaded
        kept = _quiet(found.errors, blind & (found.errors > 0), budget)
        np.add.at(result, panels.groups[kept], found.values[kept])
        budget -= float(found.errors[kept].sum())
        if kept.all():
            return result
        panels = _cut(panels.chosen(~kept), found.crossed[~kept], planes)
        found = light_of(panels)
    np.add.at(result, panels.groups, found.values)
    return result


def _cut(panels: Panels, crossed: NDArray[np.int64], planes: Array) -> Panels:
    at_plane = crossed >= 0
    split = split_panels(panels.chosen(at_plane), planes[crossed[at_plane]])
    quarters = panels.chosen(~at_plane).halved()
    return Panels(*(np.concatenate(pair) for pair in zip(split, quarters)))


def _quiet(errors: Array, blind: NDArray[np.bool_], budget: float) -> NDArray[np.bool_]:
    """Panels to keep: all, if the budget allows, else those with the smallest errors."""
    if errors.sum() <= budget and not blind.any():
        return np.ones(len(errors), bool)
    order = np.argsort(errors, kind="stable")
    kept = np.zeros(len(errors), bool)
    kept[order] = np.cumsum(errors[order]) <= _SHARE * budget
    return kept & ~blind
