"""What a ray meets: segments on faces and in cells, and the medium."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner
from propagators.maps.rays import Sources, Tally
from propagators.transport.cell_items import Items

Vector = NDArray[np.float64]

#: Cells along a ray; what lies within this of a part that was just met is that part.
TOUCH = 1e-12
#: Of a part's length, so that no ray slips through between two parts that share an end.
_SLACK = 1e-12


@inner
def cross(
    wx: float, wy: float, axis: int, face: int, along: float, unit: float, faces: Items,
    sources: Sources, flux: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Past what lies on a face, at the place `along` it.

    Light that arrives there has left its cell before; what starts there has not left the cell
    behind.
    """
    for k in range(faces.first[face], faces.first[face + 1]):
        low, high = faces.ends[k, 1 - axis], faces.ends[k, 3 - axis]
        if min(low, high) <= along < max(low, high):
            _meet(wx, wy, unit, k, faces, sources, flux, tally)


@inner
def pass_cell(
    wx: float, wy: float, x: float, y: float, start: float, stop: float, i: int, j: int,
    unit: float, cells: Items, sources: Sources, gain: Vector, flux: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Through one cell, past what lies in it."""
    cell = i * tally.cells.shape[1] + j
    first, last = cells.first[cell], cells.first[cell + 1]
    reached = start
    while first < last:
        nearest, part = stop + TOUCH, -1
        for k in range(first, last):
            way = _distance(wx, wy, x, y, cells.ends[k])
            if reached + TOUCH < way < nearest:
                nearest, part = way, k
        if part < 0:
            break
        fade(i, j, nearest - reached, sources, gain, flux, tally)
        _meet(wx, wy, unit, part, cells, sources, flux, tally)
        reached = nearest
    fade(i, j, stop - reached, sources, gain, flux, tally)


@inlined
def _meet(
    wx: float, wy: float, unit: float, part: int, items: Items, sources: Sources, flux: Vector,
    tally: Tally,
) -> None:  # fmt: skip
    """A part of a segment takes the flux and sends its own."""
    e = items.segments[part]
    if not sources.blocks[e]:
        return
    ends = items.ends[part]
    ahead = 0 if (ends[2] - ends[0]) * wy - (ends[3] - ends[1]) * wx > 0.0 else 1
    tally.passed[e, ahead] += unit
    for colour in range(flux.size):
        tally.arrived[e, 1 - ahead, colour] += flux[colour]
        flux[colour] = unit * sources.radiance[e, ahead, colour]


@inlined
def _distance(wx: float, wy: float, x: float, y: float, part: Vector) -> float:
    """How far along the ray from (x, y) a part lies; infinite if it is not met."""
    ex, ey = part[2] - part[0], part[3] - part[1]
    across = wx * ey - wy * ex
    if across == 0.0:
        return math.inf
    ox, oy = part[0] - x, part[1] - y
    share = (ox * wy - oy * wx) / across
    if share < -_SLACK or share > 1.0 + _SLACK:
        return math.inf
    return (ox * ey - oy * ex) / across


@inner
def fade(
    i: int, j: int, length: float, sources: Sources, gain: Vector, flux: Vector, tally: Tally
) -> None:
    """A chord of a cell: what the medium takes, and what the cell adds evenly along it.

    With x = σ length, P flux and G gain: P e^-x + G (1 - e^-x)/x goes on, the rest collides.
    """
    if length <= 0.0:
        return
    x = sources.extinction * length
    passing = math.exp(-x)
    share = -math.expm1(-x) / x if x > 0.0 else 1.0
    for colour in range(flux.size):
        added = length * gain[i, j, colour]
        left = passing * flux[colour] + share * added
        if x > 0.0:
            tally.collided[i, j, colour] += flux[colour] + added - left
        flux[colour] = left
