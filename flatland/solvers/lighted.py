"""Cells that light can get to: what reflects anywhere else is none of a solver's business."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels import Reflection
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.reports import Buffer

Cells = NDArray[np.bool_]

#: A link that lets less than this through is closed.
_ROUNDING = 1e-12


def lighted_cells(sweep: AnySweep, source: Buffer) -> Cells:
    """Cells (*shape) that light from a source ever gets to."""
    shape = sweep.layout.shape
    lit = (sweep.layout.view(source) != 0).any(axis=0)
    if sweep.open_share is None:
        return np.ones(shape, bool) if lit.any() else lit
    links = sweep.open_share > _ROUNDING
    inside = tuple(slice(1, -1) for _ in shape)
    # A border of cells that count as lit, so that light ends there.
    reached = np.ones([n + 2 for n in shape], np.uint8)
    reached[inside] = lit
    out = np.zeros((len(links), *reached.shape), np.uint8)
    out[(slice(None), *inside)] = links
    steps = np.ravel_multi_index(tuple((1 + sweep.stencil.offsets).T), reached.shape)
    steps -= np.ravel_multi_index((1,) * len(shape), reached.shape)
    starts = np.zeros(reached.shape, bool)
    starts[inside] = lit
    _flood(reached.reshape(-1), out.reshape(len(out), -1), steps, np.flatnonzero(starts))
    return np.asarray(reached[inside] != 0)


def reflection_in(reflection: Reflection, cells: Cells) -> Reflection:
    """What comes back in some of the cells only.

    A sealed room of white walls keeps every wave of its light: 1 − A has next to no inverse there,
    and a solver fills a dark one with the residual it is allowed. With black walls it stays dark.
    """
    kept = cells[tuple(reflection.cells.T)]
    return reflection if kept.all() else Reflection(reflection.cells[kept], reflection.lobes[kept])


@njit(cache=True)
def _flood(reached, out, steps, starts):  # type: ignore[no-untyped-def]
    stack = np.empty(reached.size, np.int64)
    stack[: starts.size] = starts
    count = starts.size
    while count > 0:
        count -= 1
        cell = stack[count]
        for d in range(steps.size):
            goal = cell + steps[d]
            if out[d, cell] and not reached[goal]:
                reached[goal] = 1
                stack[count] = goal
                count += 1
