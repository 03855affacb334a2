"""Surfels: pieces of walls, each near one corner of the cells."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.strips import clipped_walls
from flatland.facets import cut_by_cells, facet_table
from flatland.grid import Grid
from flatland.moved_segments import cells_along
from flatland.sources import Facet, Segment, Wall, facets_of, segments_of

Array = NDArray[np.float64]
Cells = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Surfels:
    """Pieces of walls (M,), in 2D or 3D.

    nodes: (M, dimension), the corner of cells that each belongs to: corner (i, j) is the lower
    one of cell (i, j), and has all that is nearer to it than to others, along each axis. areas:
    (M,), in cell sides: A_s h^{1-D}. normals: (M, dimension), unit vectors, outwards where `closed`
    (M,) says that the piece is part of a closed surface. walls: (M,), the wall it is cut from.
    """

    nodes: Cells
    areas: Array
    normals: Array
    closed: NDArray[np.bool_]
    walls: Cells

    def coarsened(self) -> Surfels:
        """The same surfels at the corners of cells twice as large: a downsampled geometry volume.

        A node of an odd number lies between two coarse ones and gives half to each, along every
        axis. Area is conserved; measured by the larger side of the cell, it is 2^{1−D} of what it
        was. (A mean over children, the rule for light, would halve what a surface blocks.)
        What it gets wrong: where in its cell a surfel was is forgotten once more on every level.
        """
        dimension = self.nodes.shape[1]
        parts = []
        for upper in itertools.product((0, 1), repeat=dimension):
            # An even node has one coarse node: the upper half of it is a second copy, left out.
            share = np.where(self.nodes % 2 == 1, 0.5, 1.0 - np.array(upper)).prod(axis=1)
            used = share > 0
            nodes = (self.nodes + np.array(upper)) // 2
            parts.append((nodes[used], (share * self.areas)[used], np.flatnonzero(used)))
        nodes, areas, number = (np.concatenate(column) for column in zip(*parts))
        return Surfels(
            nodes,
            areas * 2.0 ** (1 - dimension),
            self.normals[number],
            self.closed[number],
            self.walls[number],
        )


def surfels_of(grid: Grid, walls: Sequence[Wall]) -> Surfels:
    """Segments in 2D, facets in 3D."""
    if grid.dimension == 2:
        return surfels_of_segments(grid, segments_of(walls))
    return surfels_of_facets(grid, facets_of(walls))


def surfels_of_facets(grid: Grid, facets: Sequence[Facet]) -> Surfels:
    """Walls in 3D, cut where they pass from corner to corner: no sampling, areas are exact.

    A piece that lies exactly between corners goes to both sides by halves, so that a mirrored scene
    has the mirrored surfels. Parts that no corner of the grid is nearest to are left out.
    """
    table = facet_table(grid, facets)
    # In a grid shifted by half a cell, what is nearest to a corner is a cell.
    shifted = table._replace(vertices=table.vertices + 0.5)
    nodes = tuple(n + 1 for n in grid.shape)
    # What lies on the border between corners' realms belongs to the one in front: ask twice.
    cuts = [cut_by_cells(each, nodes) for each in (shifted, shifted.turned())]
    cells, areas, walls = (
        np.concatenate([getattr(cut, name) for cut in cuts])
        for name in ("cells", "areas", "facets")
    )
    closed = np.array([facet.closed for facet in facets], bool)
    return Surfels(cells, 0.5 * areas, table.normals[walls], closed[walls], walls)


def surfels_of_segments(grid: Grid, segments: Sequence[Segment]) -> Surfels:
    """Walls in 2D, cut where they pass from corner to corner: no sampling, lengths are exact.

    A piece that lies exactly between two corners goes to both by halves, so that a mirrored scene
    has the mirrored surfels. Segments that follow one another head to tail and close are a closed
    surface; every other one is a thin wall. Parts outside the grid belong to no corner.
    """
    outward = outward_sides(segments)
    walls, origin = clipped_walls(grid, segments)
    parts = [_pieces(wall, int(i), outward[int(i)]) for wall, i in zip(walls, origin)]
    parts = [part for part in parts if part is not None]
    if not parts:
        empty = np.empty((0, 2))
        return Surfels(empty.astype(int), empty[:, 0], empty, empty[:, 0] > 0, np.empty(0, int))
    nodes, areas, normals, closed, numbers = (np.concatenate(column) for column in zip(*parts))
    inside = np.all((nodes >= 0) & (nodes <= grid.shape), axis=1) & (areas > 0)
    return Surfels(nodes[inside], areas[inside], normals[inside], closed[inside], numbers[inside])


def outward_sides(segments: Sequence[Segment]) -> list[int]:
    """Per segment: 1 if its outside is left of start -> stop, -1 if right, 0 if it is open."""
    sides = [0] * len(segments)
    first = 0
    while first < len(segments):
        last = _closing(segments, first)
        if last is None:
            first += 1
            continue
        corners = np.array([segment.start for segment in segments[first : last + 1]])
        x, y = (corners - corners[0]).T
        turning = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        sides[first : last + 1] = [-int(np.sign(turning))] * (last + 1 - first)
        first = last + 1
    return sides


def _closing(segments: Sequence[Segment], first: int) -> int | None:
    """The segment at which the chain that starts with `first` closes."""
    for number in range(first, len(segments)):
        stop = segments[number].stop
        if np.array_equal(stop, segments[first].start):
            return number
        following = number + 1 < len(segments) and np.array_equal(stop, segments[number + 1].start)
        if not following:
            return None
    return None


def _pieces(
    wall: Array, number: int, outward: int
) -> tuple[Cells, Array, Array, NDArray[np.bool_], Cells] | None:
    """Nodes, lengths, normals, closed and numbers of the pieces of a wall (2, 2) in cells."""
    along = wall[1] - wall[0]
    length = float(np.hypot(*along))
    if length == 0:
        return None
    normal = np.array([-along[1], along[0]]) / length
    nodes, lengths = [], []
    # What lies on the border between two corners' realms belongs to the one in front: ask twice.
    for front in (normal, -normal):
        cuts, found = cells_along(wall + 0.5, front)
        nodes.append(found)
        lengths.append(0.5 * length * np.diff(cuts))
    areas = np.concatenate(lengths)
    count = areas.size
    normals = np.tile(normal * (outward or 1), (count, 1))
    return (
        np.concatenate(nodes),
        areas,
        normals,
        np.full(count, outward != 0),
        np.full(count, number),
    )
