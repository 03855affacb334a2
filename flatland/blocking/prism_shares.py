"""What is left of beams in 3D after everything that cuts them, overlaps counted once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.clipping import compiled, inner
from flatland.blocking.polygon_union import union_area
from flatland.blocking.prism_clipping import ROUNDING, Frame, pieces_in_beam
from flatland.blocking.prism_cuts import BESIDE, CUTS, Cuts, Places, place, room_for

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@compiled
def open_prisms(cuts: Cuts, places: Places, frame: Frame, centres: Array) -> tuple[Numbers, Array]:
    """The open share of every link that occurs.

    cuts: in order of their links. centres: (M, 4), of each cut's link. Returns the links (U,),
    each once, and shares (U,). A link is shut where a part cuts its centre ray, or all parts that
    touch the ray together surround it.
    """
    found, shares = np.empty_like(cuts.links), np.empty(cuts.links.size)
    polygon, buffers = room_for(places.first)
    count = start = 0
    while start < cuts.links.size:
        stop, cut, touching, covering, share = start, False, 0, 0, 0.0
        while stop < cuts.links.size and cuts.links[stop] == cuts.links[start]:
            cut = cut or cuts.reaches[stop] == CUTS
            touching += cuts.reaches[stop] != BESIDE
            covering += cuts.shares[stop] > 0.0
            share += cuts.shares[stop]
            stop += 1
        if cut or (touching > 1 and _is_surrounded(cuts, start, stop, places, centres[start])):
            share = 1.0
        elif covering > 1:
            share = _covered(cuts, start, stop, places, frame, centres[start], polygon, buffers)
        found[count], shares[count] = cuts.links[start], max(0.0, 1.0 - share)
        count += 1
        start = stop
    return found[:count], shares[:count]


@inner
def _is_surrounded(cuts, start, stop, places, centre):  # type: ignore[no-untyped-def]
    """Whether parts that touch a centre ray are on more than one side of it."""
    most = 0
    for cut in range(start, stop):
        most += places.first[cuts.parts[cut] + 1] - places.first[cuts.parts[cut]]
    points, owners, count = np.empty((most, 2)), np.empty(most, np.int64), 0
    for cut in range(start, stop):
        if cuts.reaches[cut] == BESIDE:
            continue
        for corner in range(places.first[cuts.parts[cut]], places.first[cuts.parts[cut] + 1]):
            x = places.coordinates[corner, 0] - centre[0]
            y = places.coordinates[corner, 1] - centre[1]
            if math.hypot(x, y) > ROUNDING:
                points[count, 0], points[count, 1], owners[count] = x, y, cut
                count += 1
    return surrounds(points[:count], owners[:count])


@inner
def _covered(cuts, start, stop, places, frame, centre, polygon, buffers):  # type: ignore[no-untyped-def]
    """The share of a beam that the union of several parts covers."""
    _, _, pieces, first = buffers
    most = 0
    for cut in range(start, stop):
        most += places.first[cuts.parts[cut] + 1] - places.first[cuts.parts[cut]] + 16
    points, begins, count = np.empty((6 * most, 2)), np.zeros(6 * (stop - start) + 1, np.int64), 0
    for cut in range(start, stop):
        if cuts.shares[cut] > 0.0:
            corners = place(places, cuts.parts[cut], centre, polygon)
            number = pieces_in_beam(polygon, corners, frame, buffers)
            for piece in range(number):
                begins[count + 1] = begins[count] + first[piece + 1] - first[piece]
                count += 1
            for corner in range(first[number]):
                at = begins[count] - first[number] + corner
                points[at, 0], points[at, 1] = pieces[corner, 0], pieces[corner, 1]
    return union_area(points, begins[: count + 1]) / frame.area


@compiled
def surrounds(points: Array, owners: Numbers) -> bool:
    """Whether convex polygons that touch the origin leave no side of it free.

    points: (N, 2), their corners but for those at the origin. owners: (N,), which polygon a corner
    is of, in order. True if no line through the origin has all corners on one side of it or on it,
    or if some polygons lie within such a line, on both sides of the origin, and others do not.
    """
    for i in range(owners.size):
        size = math.hypot(points[i, 0], points[i, 1])
        x, y = points[i, 0] / size, points[i, 1] / size
        left, right = False, False
        for j in range(owners.size):
            height = x * points[j, 1] - y * points[j, 0]
            left, right = left or height > ROUNDING, right or height < -ROUNDING
        if not (left and right):
            return (left or right) and _is_lined(points, owners, x, y)
    return owners.size > 0


@inner
def _is_lined(points, owners, x, y):  # type: ignore[no-untyped-def]
    """Whether polygons within the line along (x, y) lie on both sides of the origin."""
    ahead, behind, start = False, False, 0
    while start < owners.size:
        stop, within, first, last = start, True, 0.0, 0.0
        while stop < owners.size and owners[stop] == owners[start]:
            within = within and abs(x * points[stop, 1] - y * points[stop, 0]) <= ROUNDING
            along = x * points[stop, 0] + y * points[stop, 1]
            first, last = min(first, along), max(last, along)
            stop += 1
        ahead, behind = ahead or (within and last > 0.0), behind or (within and first < 0.0)
        start = stop
    return ahead and behind
