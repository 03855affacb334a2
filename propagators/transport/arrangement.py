"""Everything opaque as pieces that meet in their ends only, so that nothing crosses in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from propagators.analytic.geometry import SNAP, Geometry
from propagators.transport.meetings import find_meetings

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells. Ends nearer than this are one vertex.
SAME = 2e-10


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Pieces of walls and lights; lengths in cells.

    vertices: (V, 2). pieces: (S, 2), places of start and stop among the vertices. Side 0 of a
    piece is its left, side 1 its right. radiance: (S, 2, C), what lights send from each side, per
    angle and cell length. albedo: (S, C) of both sides. owners: (S,), surface as in `Geometry`; of
    surfaces that lie on one another the first, but their lights add up. lines: (S, 2), the grid
    line x and the grid line y that a piece lies on, or -1.
    """

    vertices: Array
    pieces: Counts
    radiance: Array
    albedo: Array
    owners: Counts
    lines: Counts

    @property
    def segments(self) -> Array:
        """Start and stop (S, 4) of each piece."""
        return self.vertices[self.pieces].reshape(-1, 4)

    @property
    def lengths(self) -> Array:
        segments = self.segments
        return np.hypot(*(segments[:, 2:] - segments[:, :2]).T)

    @property
    def reflects(self) -> bool:
        return bool(np.any(self.albedo > 0))

    @property
    def colours(self) -> int:
        return self.radiance.shape[2]


def arrange(geometry: Geometry) -> Arrangement:
    """Cut all walls where they touch or cross, and merge what lies on one another."""
    walls = geometry.walls
    cut_walls, points = find_meetings(walls)
    places = np.concatenate([walls.reshape(-1, 2), points])
    names, vertices = _distinct(places)
    ends, cuts = np.split(names, [2 * len(walls)])
    pieces, origins = _between(walls, ends, cut_walls, cuts, points)
    first, group, aligned = _merged(pieces)
    owners = geometry.surfaces[origins]
    radiance = np.zeros((len(first), 2, geometry.radiance.shape[1]))
    lights = np.flatnonzero(owners < len(geometry.emitters))
    sides = np.where(aligned[lights], 0, 1)
    np.add.at(radiance, (group[lights], sides), geometry.radiance[owners[lights]])
    kept = pieces[first]
    return Arrangement(
        vertices,
        kept,
        radiance,
        geometry.albedo[owners[first]],
        owners[first],
        _lines(vertices[kept]),
    )


def _distinct(places: Array) -> tuple[Counts, Array]:
    """A name (K,) for each place (K, 2), the same for the same point, and the points by name."""
    count = len(places)
    if not count:
        return np.empty(0, np.int64), np.empty((0, 2))
    pairs = KDTree(places).query_pairs(SAME, output_type="ndarray")
    if not len(pairs):
        names, first = np.arange(count), np.arange(count)
    else:
        links = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
        _, names = connected_components(links, directed=False)
        _, first = np.unique(names, return_index=True)
    points = places[first]
    nearest = np.rint(points)
    return names.astype(np.int64), np.where(np.abs(points - nearest) < SNAP, nearest, points)


def _between(
    walls: Array, ends: Counts, cut_walls: Counts, cuts: Counts, points: Array
) -> tuple[Counts, Counts]:
    """Pieces (K, 2) of the walls by vertices, in the walls' direction, and each one's wall.

    ends: vertices (2 S,) of the walls' starts and stops. cuts: vertices (M,) at the points (M, 2)
    that cut the walls (M,).
    """
    if not len(cuts):
        pieces, origins = ends.reshape(-1, 2), np.arange(len(walls))
    else:
        extent = walls[:, 2:] - walls[:, :2]
        along = np.einsum("ij,ij->i", points - walls[cut_walls, :2], extent[cut_walls])
        stops = np.einsum("ij,ij->i", extent, extent)
        owner = np.concatenate([np.arange(len(walls)), np.arange(len(walls)), cut_walls])
        order = np.lexsort((np.concatenate([np.zeros(len(walls)), stops, along]), owner))
        nodes = np.concatenate([ends[0::2], ends[1::2], cuts])[order]
        same = owner[order][1:] == owner[order][:-1]
        pieces = np.stack([nodes[:-1], nodes[1:]], axis=1)[same]
        origins = owner[order][:-1][same]
    kept = pieces[:, 0] != pieces[:, 1]
    return pieces[kept], origins[kept]


def _merged(pieces: Counts) -> tuple[Counts, Counts, NDArray[np.bool_]]:
    """Place of the first of each set of equal pieces, set (K,) of each piece, and which of them
    run in the first one's direction."""
    ordered = np.sort(pieces, axis=1)
    _, first, group = np.unique(ordered, axis=0, return_index=True, return_inverse=True)
    group = group.ravel()
    rank = np.argsort(np.argsort(first))
    first, group = np.sort(first), rank[group]
    return first, group, pieces[:, 0] == pieces[first[group], 0]


def _lines(ends: Array) -> Counts:
    """Grid line along each axis that pieces (S, 2, 2) lie on, or -1."""
    same = (ends[:, 0] == ends[:, 1]) & (ends[:, 0] == np.rint(ends[:, 0]))
    return np.where(same, ends[:, 0], -1).astype(np.int64)
