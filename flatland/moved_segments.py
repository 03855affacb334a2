"""Segments moved by half a cell to their front, and the cells that they then lie in.

Kaplanyan & Dachsbacher 2010, section 3.1, move each virtual point light by half a cell along its
normal and put it into the cell it then lies in, so that it lights no surface from behind. A
segment of such points is cut where the moved segment passes from cell to cell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: In cells: what lies this close to a cell border lies on it, as in Grid.contains.
ON_BORDER = 1e-9


def cells_along(moved: Array, normal: Array) -> tuple[Array, NDArray[np.int64]]:
    """Where a moved segment (2, 2) [cells] passes from cell to cell.

    normal: unit vector (2,) of its front. Returns parameters (K + 1,) from 0 to 1 along the
    segment, increasing, and the cell (K, 2) of each part in between, which may lie outside the
    grid. A segment that lies on a cell border belongs to the cell in front of it.
    """
    inner = np.concatenate([*map(_border_crossings, *moved)])
    # A border that only touches an end cuts nothing off.
    margin = ON_BORDER / max(float(np.hypot(*(moved[1] - moved[0]))), ON_BORDER)
    cuts = np.unique([0.0, *inner[(inner > margin) & (inner < 1 - margin)], 1.0])
    middles = moved[0] + 0.5 * (cuts[1:] + cuts[:-1])[:, None] * (moved[1] - moved[0])
    in_front = np.rint(moved[0]) + 0.5 * np.sign(normal)
    middles = np.where(on_border(moved, normal), in_front, middles)
    return cuts, np.floor(middles).astype(np.int64)


def on_border(moved: Array, normal: Array) -> NDArray[np.bool_]:
    """Per axis: whether the whole segment (2, 2) lies on a cell border that faces the normal."""
    nearest = np.rint(moved[0])
    return np.all(np.abs(moved - nearest) <= ON_BORDER, axis=0) & (np.abs(normal) > 0.5)


def _border_crossings(start: float, stop: float) -> Array:
    """Parameters t at which start + t (stop - start) is a whole number in between."""
    low, high = min(start, stop), max(start, stop)
    borders = np.arange(np.floor(low) + 1, np.ceil(high))
    return (borders - start) / (stop - start) if borders.size else borders
