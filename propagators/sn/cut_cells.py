"""A cell with segments in it: exact transfer of light that is uniform on each face where it enters.

Seen along ω, a ray has a place across, p. Between the places of the cell's corners and of the ends
of what lies in it, all rays enter by one face, meet the same segments in the same order and leave
by one face.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner
from propagators.transport.cell_items import Items

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells; narrower stretches are rounding.
SLIVER = 1e-15


class CutCell(NamedTuple):
    """Work space for one cell. rows: (K, 4), (p, t) of both ends of each part, smaller p first.

    ahead: (K,), side that faces along ω. order, along: parts that a ray meets, by t. beam: (C,) of
    the ray. out: (2, C), sums on the faces E and N.
    """

    rows: Vector
    ahead: Counts
    breaks: Vector
    order: Counts
    along: Vector
    beam: Vector
    out: Vector


@inner
def make_cut_cell(items: Items, colours: int) -> CutCell:
    """Room for the cell with the most in it."""
    most = 0
    for cell in range(items.first.size - 1):
        most = max(most, items.first[cell + 1] - items.first[cell])
    return CutCell(
        np.empty((most, 4)),
        np.empty(most, np.int64),
        np.empty(2 * most + 4),
        np.empty(most, np.int64),
        np.empty(most),
        np.empty(colours),
        np.empty((2, colours)),
    )


@inner
def cross_cut_cell(
    wx: float,
    wy: float,
    i: int,
    j: int,
    cell: int,
    items: Items,
    blocks: NDArray[np.bool_],
    radiance: Vector,
    weight: float,
    west: Vector,
    south: Vector,
    arrived: Vector,
    work: CutCell,
) -> None:
    """From mean radiances (C,) on W and S to those on E and N, in the same arrays.

    Coordinates in the cell are mirrored so that light goes towards larger u and v: p = -u s + v c
    runs from -s to c. Light enters through W where p > 0, else through S, and leaves through E
    where p < c - s, else through N.
    """
    c, s, first = abs(wx), abs(wy), items.first[cell]
    count = items.first[cell + 1] - first
    stops = _look(wx, wy, i, j, first, count, items, work)
    work.out.fill(0.0)
    for b in range(stops - 1):
        low, high = work.breaks[b], work.breaks[b + 1]
        if high - low <= SLIVER:
            continue
        middle = 0.5 * (low + high)
        met = _meet(middle, count, work)
        for colour in range(west.size):
            work.beam[colour] = west[colour] if middle > 0.0 else south[colour]
        for m in range(met):
            e, ahead = items.segments[first + work.order[m]], work.ahead[work.order[m]]
            for colour in range(west.size):
                if blocks[e]:
                    arrived[e, 1 - ahead, colour] += weight * (high - low) * work.beam[colour]
                    work.beam[colour] = 0.0
                work.beam[colour] += radiance[e, ahead, colour]
        face = 0 if middle < c - s else 1
        for colour in range(west.size):
            work.out[face, colour] += (high - low) * work.beam[colour]
    for colour in range(west.size):
        west[colour], south[colour] = work.out[0, colour] / c, work.out[1, colour] / s


@inlined
def _look(
    wx: float, wy: float, i: int, j: int, first: int, count: int, items: Items, work: CutCell
) -> int:
    """Places of the parts in a cell, and the sorted places where anything changes; their number."""
    c, s = abs(wx), abs(wy)
    work.breaks[0], work.breaks[1] = -s, min(0.0, c - s)
    work.breaks[2], work.breaks[3] = max(0.0, c - s), c
    stops = 4
    for k in range(count):
        part, row = items.ends[first + k], work.rows[k]
        for end in range(0, 4, 2):
            u = part[end] - i if wx > 0.0 else i + 1 - part[end]
            v = part[end + 1] - j if wy > 0.0 else j + 1 - part[end + 1]
            row[end], row[end + 1] = v * c - u * s, u * c + v * s
        if row[0] > row[2]:
            row[0], row[1], row[2], row[3] = row[2], row[3], row[0], row[1]
        turn = (part[2] - part[0]) * wy - (part[3] - part[1]) * wx
        work.ahead[k] = 0 if turn > 0.0 else 1
        for end in range(0, 4, 2):
            p, place = min(max(row[end], -s), c), stops
            while work.breaks[place - 1] > p:
                work.breaks[place] = work.breaks[place - 1]
                place -= 1
            work.breaks[place] = p
            stops += 1
    return stops


@inlined
def _meet(p: float, count: int, work: CutCell) -> int:
    """Which parts the ray at p meets, to work.order by t; their number."""
    met = 0
    for k in range(count):
        row = work.rows[k]
        if row[0] < p < row[2]:
            t = row[1] + (p - row[0]) / (row[2] - row[0]) * (row[3] - row[1])
            place = met
            while place > 0 and work.along[place - 1] > t:
                work.along[place], work.order[place] = work.along[place - 1], work.order[place - 1]
                place -= 1
            work.along[place], work.order[place] = t, k
            met += 1
    return met
