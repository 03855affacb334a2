"""The part of a convex polygon inside one beam in 3D: for kernels only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.clipping import clip, clip_to_slab, copy, inner, signed_area

Array = NDArray[np.float64]

#: In cells. A wall that passes a place by no more than this ends there.
ROUNDING = 1e-9
#: Areas under this, in the units of beam coordinates, are none.
_NOTHING = 1e-13


class Frame(NamedTuple):
    """The beams along one direction.

    direction: (3,). axes: (4, 3); rows 0 to 2 times a place in cells are coordinates across the
    beam, the last of them minus the sum of the others or zero; row 3 is the direction. All are
    whole or half numbers at centres. half: (3,), a beam reaches from −half to half around its
    centre ray. length: of the centre ray, which starts at 0. area: of the cross-section in the
    first two coordinates. slope: see `pieces_in_beam`. box: (3,), half the extent of a beam along
    the grid's axes [cells].
    """

    direction: Array
    axes: Array
    half: Array
    length: float
    area: float
    slope: float
    box: Array


@inner
def pieces_in_beam(polygon, count, frame, buffers):  # type: ignore[no-untyped-def]
    """Cut a polygon, given relative to a beam's centre, to the beam; the number of pieces.

    Piece p has corners first[p] … first[p + 1] − 1 of `pieces`. There are up to six: the ends of a
    hexagonal beam are not flat. A ray starts in the middle of its way through the cell, which with
    x, y, z along d is at x + y + z = slope · ((y − z) − (x − y)) where y is between x and z, and so
    on in turn. Both ends belong to the beam: a wall through centres is met from both sides.
    """
    between, sextant, pieces, first = buffers
    for k in range(3):
        count = clip_to_slab(polygon, count, k, -frame.half[k], frame.half[k], between)
    first[0] = number = 0
    if count < 3:
        return number
    least, most = math.inf, -math.inf
    for i in range(count):
        least, most = min(least, polygon[i, 3]), max(most, polygon[i, 3])
    if frame.slope <= least and most <= frame.length - frame.slope:
        return _keep(polygon, count, pieces, first, number)
    if frame.slope == 0.0:
        count = clip_to_slab(polygon, count, 3, 0.0, frame.length, between)
        return _keep(polygon, count, pieces, first, number)
    for j in range(3):
        k = (j + 1) % 3
        for sign in (1.0, -1.0):
            for i in range(count):
                for column in range(3):
                    sextant[i, column] = polygon[i, column]
                height = polygon[i, 3] - frame.slope * (polygon[i, k] - polygon[i, j])
                sextant[i, 3] = _snapped(height, 0.0, frame.length)
            left = clip(sextant, count, j, sign, 0.0, between)
            left = clip(sextant, left, k, sign, 0.0, between)
            left = clip_to_slab(sextant, left, 3, 0.0, frame.length, between)
            number = _keep(sextant, left, pieces, first, number)
    return number


@inner
def _snapped(height, first, last):  # type: ignore[no-untyped-def]
    """An end of a beam where a corner lies on it up to rounding."""
    if abs(height - first) <= ROUNDING:
        return first
    return last if abs(height - last) <= ROUNDING else height


@inner
def _keep(polygon, count, pieces, first, number):  # type: ignore[no-untyped-def]
    """Append a piece that has an area."""
    if abs(signed_area(polygon, count)) <= _NOTHING:
        return number
    copy(polygon, count, pieces[first[number] :])
    first[number + 1] = first[number] + count
    return number + 1
