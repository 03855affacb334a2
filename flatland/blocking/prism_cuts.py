"""Which beams in 3D the convex parts of walls meet, how much of each they cover, and whether they
reach its centre ray."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.clipping import clip_to_slab, compiled, inner, signed_area
from flatland.blocking.prism_clipping import ROUNDING, Frame, pieces_in_beam

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

#: How a part reaches a centre ray: not at all, touching it, from all sides.
BESIDE, TOUCHES, CUTS = 0, 1, 2

#: In cells. A part this close to a centre ray reaches it. A hundred times ROUNDING, so that where
#: two parts meet near a ray, at least both touch it, or one of them cuts it.
REACH = 1e-7


class Places(NamedTuple):
    """Where convex parts (P,) lie among the beams of a frame.

    coordinates: (T, 4) of their corners, of which first[p] … first[p + 1] − 1 are part p's. least,
    most: (P, 4), their extent. low, high: (P, 3), first and last cell whose beam their bounding
    box may meet. normals: (P, 3). plane: (P, 2), least and most normal · cell of the cells whose
    beam their plane may meet.
    """

    coordinates: Array
    first: Numbers
    least: Array
    most: Array
    low: Numbers
    high: Numbers
    normals: Array
    plane: Array


class Cuts(NamedTuple):
    """Parts in beams (M,): numbers of links, parts, how the centre ray is reached, and the share
    of the beam's cross-section that is covered."""

    links: Numbers
    parts: Numbers
    reaches: Numbers
    shares: Array


@compiled
def cut_prisms(places: Places, frame: Frame, shape: tuple[int, int, int], all_shares: bool) -> Cuts:
    """What every part does to every beam that it meets.

    all_shares: False leaves out, as 0, the share of a beam whose centre ray the part cuts.
    Links are numbered by their source cell in the grid with a ring of cells around it; those are
    listed that lead from or to a cell of the grid. Only cells near a part's plane are looked at.
    """
    found, shares, count = np.empty((1024, 3), np.int64), np.empty(1024), 0
    polygon, buffers = room_for(places.first)
    cell, centre = np.empty(3, np.int64), np.empty(4)
    for part in range(places.first.size - 1):
        low, high, normal = places.low[part], places.high[part], places.normals[part]
        i, j, k = _axes(normal)
        for first in range(low[i], high[i] + 1):
            cell[i] = first
            for second in range(low[j], high[j] + 1):
                cell[j] = second
                start, stop = _near_plane(normal, cell, places.plane[part], i, j, k)
                for third in range(max(low[k], start), min(high[k], stop) + 1):
                    cell[k] = third
                    if not _is_met(places, part, cell, centre, frame, shape):
                        continue
                    reach = _reach(places, part, centre, frame.length, polygon, buffers)
                    share = 0.0
                    if all_shares or reach != CUTS:
                        share = _share(places, part, centre, frame, polygon, buffers)
                    if share == 0.0 and reach == BESIDE:
                        continue
                    if count == shares.size:
                        found, shares = _longer(found, shares)
                    link = (cell[0] + 1) * (shape[1] + 2) + cell[1] + 1
                    found[count, 0] = link * (shape[2] + 2) + cell[2] + 1
                    found[count, 1], found[count, 2], shares[count] = part, reach, share
                    count += 1
    links, parts, reaches = found[:count, 0], found[:count, 1], found[:count, 2]
    return Cuts(links.copy(), parts.copy(), reaches.copy(), shares[:count])


@inner
def room_for(first):  # type: ignore[no-untyped-def]
    """A buffer for one part, and those of `pieces_in_beam`; each plane adds one corner."""
    most = 3
    for part in range(first.size - 1):
        most = max(most, first[part + 1] - first[part])
    room = most + 16
    pieces = np.empty((6 * room, 4)), np.empty(7, np.int64)
    return np.empty((room, 4)), (np.empty((room, 4)), np.empty((room, 4)), *pieces)


@inner
def place(places, part, centre, polygon):  # type: ignore[no-untyped-def]
    """Put a part into a buffer, relative to a centre; the number of its corners."""
    start = places.first[part]
    count = places.first[part + 1] - start
    for i in range(count):
        for k in range(4):
            polygon[i, k] = places.coordinates[start + i, k] - centre[k]
    return count


@inner
def _share(places, part, centre, frame, polygon, buffers):  # type: ignore[no-untyped-def]
    _, _, pieces, first = buffers
    count = place(places, part, centre, polygon)
    number = pieces_in_beam(polygon, count, frame, buffers)
    total = 0.0
    for piece in range(number):
        total += abs(signed_area(pieces[first[piece] :], first[piece + 1] - first[piece]))
    return total / frame.area


@inner
def _reach(places, part, centre, length, polygon, buffers):  # type: ignore[no-untyped-def]
    """How a part reaches a centre ray: it does if anything of it lies within REACH of the ray."""
    between = buffers[0]
    for k in range(3):
        if places.least[part, k] - centre[k] > REACH or places.most[part, k] - centre[k] < -REACH:
            return BESIDE
    count = place(places, part, centre, polygon)
    for k in range(3):
        count = clip_to_slab(polygon, count, k, -REACH, REACH, between)
    if clip_to_slab(polygon, count, 3, -REACH, length + REACH, between) == 0:
        return BESIDE
    count = place(places, part, centre, polygon)
    turn = 1.0 if signed_area(polygon, count) > 0.0 else -1.0
    depth = math.inf
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        ax, ay, bx, by = polygon[i, 0], polygon[i, 1], polygon[j, 0], polygon[j, 1]
        edge = math.hypot(bx - ax, by - ay)
        if edge > ROUNDING:
            # The ray's distance from the edge, positive inside.
            depth = min(depth, turn * (ax * by - ay * bx) / edge)
    return CUTS if ROUNDING < depth < math.inf else TOUCHES


@inner
def _axes(normal):  # type: ignore[no-untyped-def]
    """The axes in turn, the one nearest to the normal last."""
    x, y, z = abs(normal[0]), abs(normal[1]), abs(normal[2])
    if x >= y and x >= z:
        return 1, 2, 0
    return (2, 0, 1) if y >= z else (0, 1, 2)


@inner
def _near_plane(normal, cell, plane, i, j, k):  # type: ignore[no-untyped-def]
    """First and last cell along axis k with least ≤ normal · cell ≤ most."""
    rest = normal[i] * cell[i] + normal[j] * cell[j]
    one, other = (plane[0] - rest) / normal[k], (plane[1] - rest) / normal[k]
    return math.ceil(min(one, other)), math.floor(max(one, other))


@inner
def _is_met(places, part, cell, centre, frame, shape):  # type: ignore[no-untyped-def]
    """Whether a link from or to a cell of the grid may be met; puts its centre into place."""
    leaves, arrives = True, True
    for k in range(3):
        goal = cell[k] + int(frame.direction[k])
        leaves = leaves and 0 <= cell[k] < shape[k]
        arrives = arrives and 0 <= goal < shape[k]
    if not (leaves or arrives):
        return False
    for k in range(4):
        centre[k] = 0.0
        for axis in range(3):
            centre[k] += frame.axes[k, axis] * (cell[axis] + 0.5)
        first, last = -frame.slope, frame.length + frame.slope
        if k < 3:
            first, last = -frame.half[k], frame.half[k]
        if places.most[part, k] - centre[k] < first - REACH:
            return False
        if places.least[part, k] - centre[k] > last + REACH:
            return False
    return True


@inner
def _longer(found, shares):  # type: ignore[no-untyped-def]
    more, also = np.empty((2 * shares.size, 3), np.int64), np.empty(2 * shares.size)
    for i in range(shares.size):
        also[i] = shares[i]
        for k in range(3):
            more[i, k] = found[i, k]
    return more, also
