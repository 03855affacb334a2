"""Which surfaces see one another along one direction: strips, by a sweep across.

In a direction ω a point has a place across, p = -x ω_y + y ω_x, and a place along, t = x ω_x +
y ω_y. A sweep over p keeps the pieces that the ray at p meets in order of t. Between two of them
that follow one another light runs free, in the direction ω from the first and -ω from the second;
a strip ends where another piece comes between them or one of them ends. As pieces meet in their
ends only, their order never changes, and there are O(S) strips in all, not O(S²).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.beams import EDGE_ON
from propagators.analytic.compiling import inlined, inner

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


class Surfaces(NamedTuple):
    """The pieces of an arrangement for the kernels; a piece is cut in elements of equal length.

    lines: (S, 2), grid lines that pieces lie on, or -1. first, incident: pieces incident[first[v]]
    … incident[first[v + 1] - 1] end at vertex v. elements: (S + 1,), those of piece s are
    elements[s] … elements[s + 1] - 1, from its start. shines: (S, 2), which sides send light.
    """

    vertices: Vector
    pieces: Counts
    lines: Counts
    first: Counts
    incident: Counts
    elements: Counts
    shines: NDArray[np.bool_]


class View(NamedTuple):
    """What the pieces look like along one direction.

    p, t: (V,) of the vertices. low, high: (S,) ends of a piece by p. slope: dt/dp, infinite for a
    piece seen edge-on. ahead: side that faces along ω. sends: (2, S + 1), whether a piece sends
    light along ω, and along -ω; the last one stands for the outside. order: (V,), vertices by p.
    pairs: (K, 2), the piece at the beginning and at the end of each strip, S for the outside.
    across: (K, 2), from which p to which. active, since: see `find_strips`.
    """

    p: Vector
    t: Vector
    low: Counts
    high: Counts
    slope: Vector
    ahead: Counts
    sends: NDArray[np.bool_]
    order: Counts
    pairs: Counts
    across: Vector
    active: Counts
    since: Vector


@inner
def make_view(surfaces: Surfaces, order: Counts) -> View:
    """Room for one direction after the other. order: (V,), by p in the first one; changed."""
    vertices, pieces = surfaces.vertices.shape[0], surfaces.pieces.shape[0]
    # Each end of a piece ends two strips at most.
    most = 4 * pieces
    return View(
        np.empty(vertices),
        np.empty(vertices),
        np.empty(pieces, np.int64),
        np.empty(pieces, np.int64),
        np.empty(pieces),
        np.empty(pieces, np.int64),
        np.empty((2, pieces + 1), np.bool_),
        order,
        np.empty((most, 2), np.int64),
        np.empty((most, 2)),
        np.empty(pieces, np.int64),
        np.empty(pieces + 1),
    )


@inner
def turn(wx: float, wy: float, surfaces: Surfaces, view: View) -> None:
    """Look along the direction (wx, wy)."""
    p, t, order = view.p, view.t, view.order
    for v in range(p.size):
        x, y = surfaces.vertices[v, 0], surfaces.vertices[v, 1]
        p[v] = y * wx - x * wy
        t[v] = x * wx + y * wy
    # From one ordinate to the next the order hardly changes.
    for k in range(1, order.size):
        moved, place = order[k], k
        while place > 0 and p[order[place - 1]] > p[moved]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = moved
    for s in range(view.slope.size):
        a, b = surfaces.pieces[s, 0], surfaces.pieces[s, 1]
        # The left of start -> stop faces along ω if the start has the larger p.
        view.ahead[s] = 0 if p[a] > p[b] else 1
        if p[a] > p[b]:
            a, b = b, a
        view.low[s], view.high[s] = a, b
        width = p[b] - p[a]
        view.slope[s] = (t[b] - t[a]) / width if width > EDGE_ON else math.inf
        view.sends[0, s] = surfaces.shines[s, view.ahead[s]]
        view.sends[1, s] = surfaces.shines[s, 1 - view.ahead[s]]
    view.sends[:, -1] = False


@inner
def find_strips(surfaces: Surfaces, view: View) -> int:
    """The strips that carry light, to view.pairs and view.across; their number.

    active: the pieces at the ray now, by t. since: p since which each has had its neighbour.
    """
    active, since = view.active, view.since
    size, count, outside = 0, 0, view.slope.size
    for k in range(view.order.size):
        v = view.order[k]
        now = view.p[v]
        for item in range(surfaces.first[v], surfaces.first[v + 1]):
            s = surfaces.incident[item]
            if view.high[s] != v or view.slope[s] == math.inf:
                continue
            place = 0
            while active[place] != s:
                place += 1
            before = active[place - 1] if place > 0 else outside
            after = active[place + 1] if place + 1 < size else outside
            count = _end_strip(before, s, now, view, count)
            count = _end_strip(s, after, now, view, count)
            since[before] = now
            size -= 1
            for i in range(place, size):
                active[i] = active[i + 1]
        for item in range(surfaces.first[v], surfaces.first[v + 1]):
            s = surfaces.incident[item]
            if view.low[s] != v or view.slope[s] == math.inf:
                continue
            place = _place(v, s, size, view)
            before = active[place - 1] if place > 0 else outside
            after = active[place] if place < size else outside
            count = _end_strip(before, after, now, view, count)
            since[before] = since[s] = now
            for i in range(size, place, -1):
                active[i] = active[i - 1]
            active[place] = s
            size += 1
    return count


@inlined
def _end_strip(before: int, after: int, now: float, view: View, count: int) -> int:
    if (view.sends[0, before] or view.sends[1, after]) and now > view.since[before]:
        view.pairs[count, 0], view.pairs[count, 1] = before, after
        view.across[count, 0], view.across[count, 1] = view.since[before], now
        return count + 1
    return count


@inlined
def _place(v: int, s: int, size: int, view: View) -> int:
    """How many active pieces come before piece s, which begins at vertex v."""
    low, high = 0, size
    while low < high:
        middle = (low + high) // 2
        other = view.active[middle]
        if view.low[other] == v:
            before = view.slope[other] < view.slope[s]
        else:
            before = along(other, view.p[v], view) < view.t[v]
        if before:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def along(s: int, p: float, view: View) -> float:
    """Place along at which the ray at p meets piece s."""
    return view.t[view.low[s]] + (p - view.p[view.low[s]]) * view.slope[s]


@inlined
def element_at(s: int, p: float, surfaces: Surfaces, view: View) -> tuple[int, float]:
    """The element of a piece just above the place p across, and where it stops."""
    first, count = surfaces.elements[s], surfaces.elements[s + 1] - surfaces.elements[s]
    if count == 1:
        return first, math.inf
    start, stop = view.p[surfaces.pieces[s, 0]], view.p[surfaces.pieces[s, 1]]
    step = (stop - start) / count
    k = min(max(int((p - start) / step), 0), count - 1)
    if step > 0.0:
        while k < count - 1 and start + (k + 1) * step <= p:
            k += 1
        return first + k, (start + (k + 1) * step if k < count - 1 else math.inf)
    while k > 0 and start + k * step <= p:
        k -= 1
    return first + k, (start + k * step if k > 0 else math.inf)
