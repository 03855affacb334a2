"""Exact outlines of lobes, for big zooms and vector files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gui.render.picture import Layer, Scale
from gui.render.scaling import FULL, radius_factors
from gui.render.tables import circle_table

Array = NDArray[np.float64]


def lobe_outlines(
    layer: Layer, scale: Scale, window: tuple[slice, slice], cut: bool = True
) -> list[tuple[tuple[int, int], Array, Array]]:
    """Cell, positive and negative outline of every lit cell in a window.

    Outlines (K, 2) in cells from the cell's middle, x right, y up; empty if there is no such part.
    cut: keep them within their cell, as the pixels do.
    """
    count = max(96, 16 * layer.cut.basis.bands)
    table = circle_table(layer.cut.basis, layer.cut.axes, count).astype(float)
    angles = np.arange(count) * (2 * np.pi / count)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    limit = 0.5 / np.abs(unit).max(axis=1) if cut else np.full(count, np.inf)
    sizes = layer.cut.peaks[window]
    factors = radius_factors(sizes, scale.top, scale.kind, scale.decades, scale.each)
    found = []
    for i, j in np.argwhere(factors * sizes > 1e-3 * FULL):
        radii = table @ layer.cut.cells[window][i, j] * factors[i, j]
        parts = [_part(sign * radii, limit, unit) for sign in (1.0, -1.0)]
        found.append(((int(i + window[0].start), int(j + window[1].start)), parts[0], parts[1]))
    return found


def _part(radii: Array, limit: Array, unit: Array) -> Array:
    positive = np.clip(radii, 0.0, limit)
    if positive.max() < 1e-4:
        return np.zeros((0, 2))
    return np.asarray(positive[:, None] * unit)
