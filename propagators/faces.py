"""The faces of an axial neighbour, as its cell's centre sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propagators.directions import AXIAL, Array, angle, perpendicular
from propagators.regions import Arcs, Polygons, Regions


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of the neighbour at `offset`, without the one that is shared: the front one first.

    normals (F, dimension): unit, out of the neighbour. centres (F, dimension): seen from the
    source's centre, in cells. regions: the directions from there. F is 3 in 2D and 5 in 3D.
    """

    normals: Array
    centres: Array
    regions: Regions


def faces_of(offset: Array) -> Faces:
    """Faces of the neighbour at an axial offset (dimension,)."""
    along = np.asarray(offset, float)
    if along.size == 2:
        across = np.array([-along[1], along[0]])
        normals = np.stack([along, across, -across])
        centres = along + 0.5 * normals
        return Faces(normals, centres, _arcs(centres, normals))
    sides = AXIAL[3][AXIAL[3] @ along == 0]
    normals = np.vstack([along, sides])
    centres = along + 0.5 * normals
    return Faces(normals, centres, _squares(centres, normals))


def _arcs(centres: Array, normals: Array) -> Arcs:
    tangent = 0.5 * np.stack([-normals[:, 1], normals[:, 0]], axis=-1)
    start, stop = angle(centres - tangent), angle(centres + tangent)
    width = (stop - start + np.pi) % (2 * np.pi) - np.pi
    start, width = np.where(width < 0, start + width, start), np.abs(width)
    return Arcs(start, start + width, width)


def _squares(centres: Array, normals: Array) -> Polygons:
    """Counter-clockwise around normals that point away from the source, so from outside too."""
    first, second = perpendicular(normals)
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    vertices = [centres + 0.5 * (a * first + b * second) for a, b in corners]
    return Polygons(np.stack(vertices, axis=1))
