"""Parallel lines through a scene, and the walls that each meets.

In a direction ω, lines stand on a square lattice of `density` points a cell side, in the plane
across ω's largest axis c, shifted by two numbers in [0, 1). A line at (u, v) runs through
(u + z s_a, v + z s_b, z) with s = ω / ω_c and a, b the axes after c. Every sheet of wall is
rasterised on the lattice, so that what a line meets costs no search. Lines know nothing of light:
both directions of travel use them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner
from propagators.analytic_3d.elements import Rasters

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]

#: A sheet with a smaller cosine to the lines is seen edge-on and met by none.
EDGE_ON = 1e-9


class Lattice(NamedTuple):
    """Lines along one direction. axes: (c, a, b). slopes: (s_a, s_b). first: (2,) of the lines at
    (first + index) · step; counts: how many along u and v."""

    c: int
    a: int
    b: int
    slope_a: float
    slope_b: float
    first_u: float
    first_v: float
    step: float
    count_u: int
    count_v: int


class Hits(NamedTuple):
    """Where lines meet walls: lists by growing z, one per line.

    heads: (lines,) first hit of each, -1 at the end. following, heights (z), and the sides that
    face along ω and against it.
    """

    heads: Indices
    following: Indices
    heights: Vector
    along: Indices
    against: Indices


@inner
def make_lattice(direction: Vector, shift: Vector, density: float, shape: Indices) -> Lattice:
    """The lines along a direction, whose largest component is positive, that may meet the grid."""
    c = 0
    for axis in range(1, 3):
        if direction[axis] > direction[c]:
            c = axis
    a, b = (c + 1) % 3, (c + 2) % 3
    slope_a, slope_b = direction[a] / direction[c], direction[b] / direction[c]
    low_u, high_u = min(0.0, -shape[c] * slope_a), shape[a] + max(0.0, -shape[c] * slope_a)
    low_v, high_v = min(0.0, -shape[c] * slope_b), shape[b] + max(0.0, -shape[c] * slope_b)
    first_u = math.ceil(low_u * density - shift[0]) + shift[0]
    first_v = math.ceil(low_v * density - shift[1]) + shift[1]
    count_u = max(0, math.floor(high_u * density - first_u) + 1)
    count_v = max(0, math.floor(high_v * density - first_v) + 1)
    step = 1.0 / density
    return Lattice(c, a, b, slope_a, slope_b, first_u, first_v, step, count_u, count_v)


@inner
def find_hits(lattice: Lattice, sheets: Rasters) -> Hits:
    """All hits of all lines."""
    hits = _make_hits(lattice.count_u * lattice.count_v, 1024)
    count = 0
    crossings = np.empty(64)
    for s in range(sheets.planes.shape[0]):
        plane = sheets.planes[s]
        rise = plane[lattice.a] * lattice.slope_a + plane[lattice.b] * lattice.slope_b
        rise += plane[lattice.c]
        if abs(rise) < EDGE_ON:
            continue
        edges = sheets.edges[sheets.first[s] : sheets.first[s + 1]]
        if crossings.size < edges.shape[0]:
            crossings = np.empty(2 * edges.shape[0])
        low, high = _rows_of(edges, lattice)
        for j in range(low, high):
            v = (lattice.first_v + j) * lattice.step
            found = _cross(edges, v, lattice, crossings)
            if count + lattice.count_u > hits.heights.size:
                hits = _grown(hits, count + lattice.count_u)
            for k in range(0, found - 1, 2):
                start = math.ceil(crossings[k] / lattice.step - lattice.first_u)
                stop = math.ceil(crossings[k + 1] / lattice.step - lattice.first_u)
                for i in range(max(0, int(start)), min(lattice.count_u, int(stop))):
                    u = (lattice.first_u + i) * lattice.step
                    z = (plane[3] - plane[lattice.a] * u - plane[lattice.b] * v) / rise
                    element = _element_at(u, v, z, s, lattice, sheets)
                    if element >= 0:
                        _insert(i * lattice.count_v + j, z, element, rise > 0.0, count, hits)
                        count += 1
    return hits


@inner
def _make_hits(lines: int, room: int) -> Hits:
    heads = np.full(lines, -1)
    following, along, against = (
        np.empty(room, np.int64),
        np.empty(room, np.int64),
        np.empty(room, np.int64),
    )
    return Hits(heads, following, np.empty(room), along, against)


@inner
def _grown(hits: Hits, needed: int) -> Hits:
    room, size = 2 * needed, hits.heights.size
    following, along, against = (
        np.empty(room, np.int64),
        np.empty(room, np.int64),
        np.empty(room, np.int64),
    )
    heights = np.empty(room)
    following[:size], heights[:size] = hits.following, hits.heights
    along[:size], against[:size] = hits.along, hits.against
    return Hits(hits.heads, following, heights, along, against)


@inner
def _rows_of(edges: Vector, lattice: Lattice) -> tuple[int, int]:
    """Rows of lines that may meet a sheet."""
    low, high = math.inf, -math.inf
    for e in range(edges.shape[0]):
        v = edges[e, 0, lattice.b] - edges[e, 0, lattice.c] * lattice.slope_b
        low, high = min(low, v), max(high, v)
    first = math.ceil(low / lattice.step - lattice.first_v)
    last = math.floor(high / lattice.step - lattice.first_v)
    return max(0, first), min(lattice.count_v, last + 1)


@inner
def _cross(edges: Vector, v: float, lattice: Lattice, crossings: Vector) -> int:
    """Places u, sorted, at which the row v enters and leaves a sheet."""
    found = 0
    for e in range(edges.shape[0]):
        v0 = edges[e, 0, lattice.b] - edges[e, 0, lattice.c] * lattice.slope_b
        v1 = edges[e, 1, lattice.b] - edges[e, 1, lattice.c] * lattice.slope_b
        if (v0 <= v) == (v1 <= v):
            continue
        u0 = edges[e, 0, lattice.a] - edges[e, 0, lattice.c] * lattice.slope_a
        u1 = edges[e, 1, lattice.a] - edges[e, 1, lattice.c] * lattice.slope_a
        u, place = u0 + (v - v0) / (v1 - v0) * (u1 - u0), found
        while place > 0 and crossings[place - 1] > u:
            crossings[place] = crossings[place - 1]
            place -= 1
        crossings[place] = u
        found += 1
    return found


@inner
def _element_at(u: float, v: float, z: float, s: int, lattice: Lattice, sheets: Rasters) -> int:
    """The element of a sheet at a hit, -1 where there is none."""
    column, row = 0.0, 0.0
    for axis in range(3):
        if axis == lattice.c:
            place = z
        elif axis == lattice.a:
            place = u + z * lattice.slope_a
        else:
            place = v + z * lattice.slope_b
        place -= sheets.origins[s, axis]
        column += place * sheets.axes[s, 0, axis]
        row += place * sheets.axes[s, 1, axis]
    i = min(max(math.floor(column), 0), sheets.counts[s, 0] - 1)
    j = min(max(math.floor(row), 0), sheets.counts[s, 1] - 1)
    return int(sheets.table[sheets.start[s] + j * sheets.counts[s, 0] + i])


@inner
def _insert(line: int, z: float, element: int, front: bool, place: int, hits: Hits) -> None:
    """Puts a hit into a line's list. front: the element's front faces along ω."""
    hits.heights[place] = z
    hits.along[place] = 2 * element if front else 2 * element + 1
    hits.against[place] = 2 * element + 1 if front else 2 * element
    before, after = -1, hits.heads[line]
    while after >= 0 and hits.heights[after] < z:
        before, after = after, hits.following[after]
    hits.following[place] = after
    if before < 0:
        hits.heads[line] = place
    else:
        hits.following[before] = place
