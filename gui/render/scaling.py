"""From intensities to sizes: linear or logarithmic, for all cells or for each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]

#: Radius of a lobe that just reaches the side of its cell, in cells.
FULL = 0.48


def shown_sizes(peaks: Array, top: float, scale: str, decades: float) -> Array:
    """How large each cell's light is drawn, 1 for `top`: linear, or by its logarithm.

    On the logarithmic scale top · 10^-decades and less is 0. Zero stays zero.
    """
    sizes = np.abs(np.asarray(peaks, float))
    if not top > 0:
        return np.zeros_like(sizes)
    if scale == "linear":
        return np.asarray(sizes / top)
    floor = top * 10.0**-decades
    ratio = np.log10(np.maximum(sizes, floor) / floor) / decades
    return np.asarray(np.maximum(ratio, 0.0))


def radius_factors(peaks: Array, top: float, scale: str, decades: float, each: bool) -> Array:
    """Radius in cells per unit of intensity, so that shapes stay as they are.

    each: every cell by itself, so that all lobes are as large as `top`. Lobes larger than their
    cell are cut off at its sides when they are drawn.
    """
    sizes = np.asarray(peaks, float)
    lit = sizes > 1e-9 * top if each else sizes > 0
    shown = np.ones_like(sizes) if each else shown_sizes(sizes, top, scale, decades)
    safe = np.where(lit, sizes, 1.0)
    return np.where(lit, FULL * shown / safe, 0.0)


def fitted_top(peaks: Array) -> float:
    """The intensity to take as full size: the largest; 1 where there is no light."""
    largest = float(np.max(peaks, initial=0.0))
    return largest if largest > 0 else 1.0
