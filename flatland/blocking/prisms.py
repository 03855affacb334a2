r"""Beams in 3D: prisms across cells, and what facets do to them.

::

      +---+        +---+           .+.        What a cell looks like along d, and so the
      |   |        |   |         +`   `+      cross-section of its beams: a square along an axis,
      | * |        | * |         |  *  |      a rectangle of 1 x √2 along the diagonal of a face,
      |   |        |   |         +.   .+      a regular hexagon of area √3 along that of a cell.
      +---+        +---+           `+`        Beams fill space 1, 2 and 3 times.
    (1, 0, 0)    (1, 1, 0)      (1, 1, 1)

A ray of a beam joins the middles of its ways through the two cells. That is a ray between the
planes through the two centres in all beams but the hexagonal ones, whose ends bulge: cut off by
planes, their corners would stick out of the two cells, and a wall on the face behind a cell would
stop 1/24 of the light that leaves the cell away from it.

A facet, cut into convex parts, is clipped by the planes of each beam that it meets, and projected
along d. Where several parts cover some of one beam, the area of their union is added up strip by
strip; nothing is sampled. A part reaches the centre ray if anything of it lies within 1e-7 cells of
it; what passes the ray by no more than 1e-9 cells has not crossed it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.convex import convex_parts
from flatland.blocking.covers import Covers
from flatland.blocking.prism_clipping import ROUNDING, Frame
from flatland.blocking.prism_cuts import REACH, Cuts, Places, cut_prisms
from flatland.blocking.prism_shares import open_prisms
from flatland.grid import Grid
from flatland.sources import Facet

Array = NDArray[np.float64]
Cells = NDArray[np.int64]


class Prisms:
    """What facets do to the beams of a grid in 3D."""

    def __init__(self, grid: Grid, facets: Sequence[Facet]) -> None:
        self.shape = grid.shape
        self._parts = convex_parts(grid, facets)

    def links(self, direction: Cells) -> tuple[Cells, Array]:
        """Links along a forward direction that walls meet: source cells (U, 3), open shares (U,).

        Sources lie in the grid or in the ring of cells around it.
        """
        frame = beam_frame(tuple(direction.tolist()))
        places = self._places(frame)
        cuts = cut_prisms(places, frame, self.shape, False)
        order = np.argsort(cuts.links, kind="stable")
        cuts = Cuts(*(column[order] for column in cuts))
        centres = (self._cells(cuts.links) + 0.5) @ frame.axes.T
        links, shares = open_prisms(cuts, places, frame, centres)
        return self._cells(links), shares

    def covers(self, direction: Cells) -> Covers:
        """What each wall does to each beam along a forward direction."""
        frame = beam_frame(tuple(direction.tolist()))
        cuts = cut_prisms(self._places(frame), frame, self.shape, True)
        walls, normals = self._parts.facets[cuts.parts], self._parts.normals[cuts.parts]
        return Covers(self._cells(cuts.links), cuts.shares, walls, normals)

    def _cells(self, links: Cells) -> Cells:
        padded = tuple(n + 2 for n in self.shape)
        return np.stack(np.unravel_index(links, padded), axis=1) - 1

    def _places(self, frame: Frame) -> Places:
        """The walls in the coordinates of a frame's beams."""
        vertices, first, normals, _ = self._parts
        coordinates = vertices @ frame.axes.T
        # Walls within rounding of a plane through centres lie on it, and are met from both sides.
        planes = np.round(coordinates[:, 3] - 0.5 * frame.length) + 0.5 * frame.length
        on_plane = np.abs(coordinates[:, 3] - planes) <= ROUNDING
        coordinates[:, 3] = np.where(on_plane, planes, coordinates[:, 3])
        middle = 0.5 + 0.5 * frame.direction
        least, most = _extents(vertices, first)
        low = np.maximum(np.ceil(least - middle - frame.box - REACH), -1)
        high = np.minimum(np.floor(most - middle + frame.box + REACH), self.shape)
        slope = normals @ frame.direction
        across = np.abs(normals - slope[:, None] / frame.length * frame.direction).sum(axis=1)
        radius = 0.5 * across + (0.5 + frame.slope / frame.length) * np.abs(slope) + 2 * REACH
        owners = np.repeat(np.arange(len(normals)), np.diff(first))
        heights = np.sum(vertices * normals[owners], axis=1)[:, None]
        lowest, highest = _extents(heights, first)
        shift = normals @ middle
        plane = np.stack([lowest[:, 0] - shift - radius, highest[:, 0] - shift + radius], axis=1)
        cells = low.astype(np.int64), high.astype(np.int64)
        return Places(coordinates, first, *_extents(coordinates, first), *cells, normals, plane)


def _extents(values: Array, first: Cells) -> tuple[Array, Array]:
    """Least and most (P, columns) of the rows of each part."""
    if len(first) == 1:
        return values[:0], values[:0]
    return np.minimum.reduceat(values, first[:-1]), np.maximum.reduceat(values, first[:-1])


@cache
def beam_frame(direction: tuple[int, ...]) -> Frame:
    """The coordinates of beams along a direction.

    Turned so that d = (1, 1, 1), they are x − y, y − z and z − x: the hexagon is where none of them
    exceeds 1. Along (1, 1, 0) they are x − y and z, along (1, 0, 0) y and z.
    """
    d = np.array(direction, float)
    along, across = np.flatnonzero(d), np.flatnonzero(d == 0)
    axes, half = np.zeros((4, 3)), np.zeros(3)
    rows = [d * (np.eye(3)[i] - np.eye(3)[j]) for i, j in pairwise(along)]
    axes[:2], axes[3] = rows + [np.eye(3)[i] for i in across], d
    half[:2] = [1.0] * len(rows) + [0.5] * len(across)
    if not across.size:
        axes[2], half[2] = -axes[0] - axes[1], 1.0
    # The square is of area 1, the rectangle 2 x 1, and the hexagon what of 2 x 2 has |z − x| ≤ 1.
    length = area = float(len(along))
    box = np.where(d != 0, 0.5 * min(length, 2.0), 0.5)
    return Frame(d, axes, half, length, area, 0.0 if across.size else 0.5, box)
