"""The grids of an octree, and how many there can be."""

from __future__ import annotations

from numbers import Integral

from flatland.errors import bad_input
from flatland.grid import Grid


def most_levels(shape: tuple[int, ...]) -> int:
    """Levels from a grid of this shape down to a single cell: 1 + ⌈log₂ of the longest side⌉."""
    return 1 + (max(shape) - 1).bit_length()


def level_grids(grid: Grid, levels: int) -> tuple[Grid, ...]:
    """The grid and its `levels` − 1 coarser ones.

    Sizes need not be powers of two: an axis of odd length keeps its last, half-covered cell, whose
    missing children are dark. The border of such a level lies up to one of its cells further out.
    Raises InputError for less than one level and for more than lead down to a single cell.
    """
    most = most_levels(grid.shape)
    whole = isinstance(levels, Integral) and not isinstance(levels, bool)
    if not whole or not 1 <= levels <= most:
        size = " x ".join(map(str, grid.shape))
        last = f"{size} cells become one cell at level {most - 1}"
        raise bad_input("levels", levels, f"must be a whole number, 1 to {most}: {last}")
    grids = [grid]
    for _ in range(int(levels) - 1):
        grids.append(grids[-1].coarsen())
    return tuple(grids)
