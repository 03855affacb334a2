"""Planar polygons in 3D: the rules that lights and occluders made of one must keep."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Of a polygon's size: how far its vertices may lie off one plane. They are used as they are.
PLANAR = 1e-6
#: Of a polygon's size: what is not wider than this has no area.
THIN = 1e-9
#: Of the largest coordinate: what may be rounding.
ROUNDING = 1e-12


def polygon_fault(vertices: Array) -> str | None:
    """The rule that a polygon (V, 3) breaks, V ≥ 3, or None.

    Neighbours must differ, all vertices must lie in one plane, edges must neither cross nor touch,
    and it must have an area. It need not be convex.
    """
    arms = vertices - vertices.mean(axis=0)
    size, rounding = np.abs(arms).max(), ROUNDING * np.abs(vertices).max()
    if repeated := _repeated(vertices, rounding):
        first, second = repeated
        rule = f"has the same point as vertex {first} and vertex {second}"
        return rule + "; the outline closes itself"
    # Axes in order of how far the polygon reaches along them: the last is its normal.
    along = arms @ np.linalg.svd(arms / size)[2].T
    wide, off = np.abs(along[:, 1]).max(), np.abs(along[:, 2])
    if wide <= max(THIN * size, rounding):
        return "must have an area: its points lie on one line"
    allowed = max(PLANAR * size, rounding)
    if off.max() > allowed:
        number, far = int(np.argmax(off)) + 1, float(off.max())
        rule = f"must lie in one plane: vertex {number} is {far:.2g} m off it"
        return f"{rule}, {allowed:.2g} m are allowed"
    if not shapely.Polygon(along[:, :2] / size).is_valid:
        return "must be given in order round its outline: its edges cross or touch"
    return None


def _repeated(vertices: Array, rounding: float) -> tuple[int, int] | None:
    """The first pair of neighbours in the same place, counted from 1."""
    steps = np.abs(np.roll(vertices, -1, axis=0) - vertices).max(axis=1)
    same = np.flatnonzero(steps <= rounding)
    if not same.size:
        return None
    return int(same[0]) + 1, (int(same[0]) + 1) % len(vertices) + 1
