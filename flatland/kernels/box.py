"""The box of cells that light is in: what lies outside is neither read nor written."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
from flatland.kernels.reports import Buffer

#: First and last (excluded) cell along each axis.
Box = tuple[tuple[int, int], ...]


def whole(shape: Sequence[int]) -> Box:
    """All cells of a grid."""
    return tuple((0, cells) for cells in shape)


def nothing(shape: Sequence[object]) -> Box:
    """No cell, along as many axes."""
    return tuple((0, 0) for _ in shape)


def is_empty(box: Box) -> bool:
    # Asked many times a run: a generator takes 2.7 times as long.
    for first, last in box:  # noqa: SIM110
        if first >= last:
            return True
    return False


def grown(box: Box, shape: Sequence[int], cells: int) -> Box:
    """The box and what lies up to `cells` steps from it, inside the grid."""
    if is_empty(box):
        return box
    return tuple(
        (max(0, first - cells), min(size, last + cells)) for (first, last), size in zip(box, shape)
    )


def touches_border(box: Box, shape: Sequence[int]) -> bool:
    """Whether light of the box can leave the grid in one step."""
    sides = zip(box, shape)
    return not is_empty(box) and any(first == 0 or last == size for (first, last), size in sides)


def hull(first: Box, second: Box) -> Box:
    """The smallest box round two."""
    if is_empty(first) or is_empty(second):
        return first if is_empty(second) else second
    return tuple((min(a, c), max(b, d)) for (a, b), (c, d) in zip(first, second))


def cells_of(box: Box) -> Any:
    """Index of the box in an array (..., *shape)."""
    return (..., *(slice(first, last) for first, last in box))


def cell_count(box: Box) -> int:
    count = 1
    for first, last in box:
        count *= max(0, last - first)
    return count


def clear_outside(layout: Layout, buffer: Buffer, old: Box, new: Box) -> None:
    """Zeros in the cells of `old` that are not in `new`."""
    if is_empty(new):
        layout.view(buffer)[cells_of(old)] = 0
        return
    rest = list(old)
    for axis, ((first, last), (begin, end)) in enumerate(zip(old, new)):
        for slab in ((first, min(begin, last)), (max(end, first), last)):
            if slab[0] < slab[1]:
                cells = (*rest[:axis], slab, *rest[axis + 1 :])
                layout.view(buffer)[cells_of(cells)] = 0
        rest[axis] = (max(first, begin), min(last, end))


def trimmed(
    light: NDArray[np.floating], box: Box, limit: float = 0.0
) -> tuple[Box, NDArray[np.float64]]:
    """The box without outer layers whose coefficients are all at most `limit`, which become zero.

    light: (components, *shape). Gives also the sums (components,) of what was dropped.
    """
    dropped = np.zeros(len(light))
    if is_empty(box):
        return nothing(light.shape[1:]), dropped
    # One layer thick along the axis that a grid of two dimensions lacks.
    light = light if light.ndim == 4 else light[:, None]
    ends = np.array(box if len(box) == 3 else ((0, 1), *box))
    _trim(light, ends, limit, dropped)
    found = tuple((int(first), int(last)) for first, last in ends[-len(box) :])
    return (nothing(found), dropped) if is_empty(found) else (found, dropped)


@njit(cache=True, error_model="numpy", nogil=True)
def _trim(light, ends, limit, dropped):  # type: ignore[no-untyped-def]
    """Move `ends` (3, 2) inwards; zeroes what is left behind and adds it to `dropped`."""
    for axis in range(3):
        for side in range(2):
            while ends[axis, 0] < ends[axis, 1]:
                layer = ends.copy()
                layer[axis, 1 - side] = ends[axis, 0] + 1 if side == 0 else ends[axis, 1] - 1
                (a, b), (c, d), (e, f) = layer
                part = light[:, a:b, c:d, e:f]
                if not _is_small(part, limit):
                    break
                if limit > 0:
                    for component in range(dropped.size):
                        dropped[component] += part[component].sum()
                    part[...] = 0
                ends[axis, side] += 1 - 2 * side


@njit(cache=True, error_model="numpy", nogil=True)
def _is_small(part, limit):  # type: ignore[no-untyped-def]
    for component in part:
        for plane in component:
            for row in plane:
                for value in row:
                    if not abs(value) <= limit:
                        return False
    return True


def sweep_box(layout: Layout, box: Box) -> tuple[int, NDArray[np.int64]]:
    """Rows of the box, and what a sweep needs to find them and their columns.

    Five numbers: first plane, first row of a plane, rows in a plane, first column, last column
    (excluded), the columns in whole vectors of the layout.
    """
    (plane, last_plane), (row, last_row), (first, last) = box if len(box) == 3 else ((0, 1), *box)
    if is_empty(box):
        return 0, np.array([0, 0, 1, 0, 0])
    lanes = layout.lanes
    columns = (first // lanes * lanes, -(-last // lanes) * lanes)
    rows = (last_plane - plane) * (last_row - row)
    return rows, np.array([plane, row, last_row - row, *columns])
