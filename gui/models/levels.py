"""Levels of an octree: what a run holds on each, and what is read from all."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from flatland.grid import Grid
from flatland.simulation import Simulation
from propagators.base import Option

#: How an octree is filled and read, for the editor; the same words as the command line's.
LEVEL_OPTIONS = (
    Option(
        "normalization",
        str,
        "flux",
        "levels get flux (2^i times the mean) or the mean of level 0",
        ("flux", "mean"),
    ),
    Option("falloff", str, "cells", "light fades per cells or per metres", ("cells", "metres")),
    Option(
        "index",
        str,
        "finest",
        "which level a place is read from: the finest lit one, or the same around it",
        ("finest", "symmetric"),
    ),
    Option(
        "patience",
        float,
        1.0,
        "read a level after so many times the steps that its first light took",
        minimum=1.0,
        maximum=100.0,
    ),
)

NAMES = ("source", "target", "accumulated")


def count_of(simulation: Simulation) -> int:
    return int(getattr(simulation, "levels", 1))


def start(simulation: Simulation) -> None:
    """Inject, and fill the coarse levels."""
    begin: Any = getattr(simulation, "start", simulation.inject)
    begin()


def downsample(simulation: Any) -> None:
    """Level 0's light as it is now, and the walls, to all coarse levels."""
    simulation.downsample()
    simulation.downsample_geometry()


def level_fields(simulation: Any) -> tuple[dict[str, Field], ...]:
    """All fields of every level, finest first."""
    views = [simulation.level(number) for number in range(count_of(simulation))]
    return tuple({name: getattr(view, name) for name in NAMES} for view in views)


def merged_fields(simulation: Any, blend: float | None) -> dict[str, Field]:
    """Every cell of level 0 from the level that the index volume names."""
    return {name: simulation.merge(blend, name) for name in NAMES}


def ratio_of(grid: Grid, finest: Grid) -> int:
    """Cells of the finest grid along a side of one of this grid's."""
    return max(1, round(grid.spacing / finest.spacing))


def coarsened(field: Field, levels: int) -> Field:
    """Means over children, so many times; children beyond the border are dark."""
    for _ in range(levels):
        grid = field.grid.coarsen()
        values = np.asarray(field.values, float)
        dimension = field.grid.dimension
        for axis in range(values.ndim - dimension, values.ndim):
            values = _halved(values, axis)
        field = Field(grid, field.basis, values)
    return field


def _halved(values: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Means of pairs along an axis; a last, single entry is paired with zero."""
    moved = np.moveaxis(values, axis, 0)
    if len(moved) % 2:
        moved = np.concatenate([moved, np.zeros_like(moved[:1])])
    return np.moveaxis((moved[::2] + moved[1::2]) / 2, 0, axis)
