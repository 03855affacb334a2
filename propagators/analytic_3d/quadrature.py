"""Light of area lights on groups of panels: panels are cut until the error is small enough."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from propagators.analytic_3d.panels import PanelLight, Panels, split_panels

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Rounds after which panels are 1e-6 cells wide and kept as they are.
_MOST_ROUNDS = 20
#: Rounds in which panels are cut at planes of lights, whatever their errors.
_BLIND_ROUNDS = 3
#: Cells. Widest panel that a wall may shade.
_WIDE = 0.51
#: Share of what cutting a panel changed that each of its parts is taken to be off by, at least.
_TRUST = 1 / 16


def integrate(
    panels: Panels,
    light_of: Callable[[Panels], PanelLight],
    planes: Array,
    group_count: int,
    tolerance: float,
) -> Array:
    """Sums (groups, C, size) over panels, to a relative L2 error of all sums together.

    planes: (L, 4) of the lights. Panels that a wall may shade are cut down to half a cell at once,
    and those that a light's plane crosses along it: two rules that agree may both have missed what
    lies between their points. Then those with the largest estimated errors are cut. Errors within
    a group may have one sign and are added up; groups count by their squares, up to
    (tolerance |sums|)².

    The estimate belongs to the coarser of two rules, so that the error is mostly smaller still. It
    may be too small by accident, as where errors along and across a panel cancel: parts of a panel
    count at least as a share of what cutting it has changed.
    """
    found = light_of(panels)
    result = np.zeros((group_count, *found.values.shape[1:]))
    np.add.at(result, panels.groups, found.values)
    budget = (tolerance * float(np.linalg.norm(result))) ** 2
    result.fill(0.0)
    spent = np.zeros(group_count)
    for rounds in range(_MOST_ROUNDS):
        blind = (found.crossed >= 0) & (rounds < _BLIND_ROUNDS) & (found.errors > 0)
        blind |= found.shaded & (panels.widths > _WIDE)
        kept = _quiet(found.errors, panels.groups, spent, blind, budget, 0.5 ** (rounds + 1))
        np.add.at(result, panels.groups[kept], found.values[kept])
        np.add.at(spent, panels.groups[kept], found.errors[kept])
        if kept.all():
            return result
        cut, before = panels.chosen(~kept), found.values[~kept]
        panels, parents = _cut(cut, found.crossed[~kept], planes)
        found = light_of(panels)
        changes = before
        np.subtract.at(changes, parents, found.values)
        changed = np.linalg.norm(changes.reshape(len(before), -1), axis=1)
        found = found._replace(errors=np.maximum(found.errors, _TRUST * changed[parents]))
    np.add.at(result, panels.groups, found.values)
    return result


def _cut(
    panels: Panels, crossed: NDArray[np.int64], planes: Array
) -> tuple[Panels, NDArray[np.int64]]:
    """Panels in parts, and which panel each is a part of."""
    at_plane, others = np.flatnonzero(crossed >= 0), np.flatnonzero(crossed < 0)
    split, origins = split_panels(panels.chosen(at_plane), planes[crossed[at_plane]])
    quarters = panels.chosen(others).halved()
    parts = Panels(
        np.concatenate([split.corners, quarters.corners]),
        np.concatenate([split.normals, quarters.normals]),
        np.concatenate([split.groups, quarters.groups]),
    )
    return parts, np.concatenate([at_plane[origins], np.repeat(others, 4)])


def _quiet(
    errors: Array,
    groups: NDArray[np.int64],
    spent: Array,
    blind: Flags,
    budget: float,
    spare: float,
) -> Flags:
    """Panels to keep: all, if the budget allows, else those with the smallest errors.

    spent: (groups,) errors of panels kept before. spare: the share of the budget to leave.
    """

    def cost(kept: Flags) -> float:
        added = np.bincount(groups[kept], errors[kept], len(spent))
        return float(np.sum((spent + added) ** 2))

    candidates = np.sort(errors[~blind])
    if not blind.any() and cost(~blind) <= budget:
        return ~blind
    low, high = 0, len(candidates)
    while low < high:
        middle = (low + high + 1) // 2
        if cost(~blind & (errors <= candidates[middle - 1])) <= (1 - spare) * budget:
            low = middle
        else:
            high = middle - 1
    limit = candidates[low - 1] if low else -1.0
    return np.asarray(~blind & (errors <= limit))
