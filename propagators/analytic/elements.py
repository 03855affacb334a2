"""Walls cut into elements, on each of which radiosity is taken as constant.

Radiosity has infinite slopes in corners, but finer elements there were measured to save 5 % of
the error of a field at most, for a tenth to a half more elements: all are equally long.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH
from propagators.analytic.geometry import Geometry
from propagators.analytic.overlaps import uncovered
from propagators.analytic.rays import hit_distances

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells. Shadow edges nearer than this to one another would leave elements of rounding.
SHORTEST = 1e-6


@dataclass(frozen=True, eq=False)
class Elements:
    """Sides of walls in pieces; each lights and receives on the left of start -> stop.

    panels: (N, 4) straight pieces between corners, in cells. surfaces: (N,) whose they are, as in
    `Geometry`. segments: (K, 4), of which first[n] … first[n + 1] - 1 cut panel n, in order.
    """

    panels: Array
    surfaces: Counts
    first: Counts
    segments: Array

    @property
    def lengths(self) -> Array:
        return np.hypot(*(self.segments[:, 2:] - self.segments[:, :2]).T)

    @property
    def counts(self) -> Counts:
        """Elements of each panel (N,)."""
        return np.diff(self.first)

    @property
    def owners(self) -> Counts:
        """Surface (K,) of each element."""
        return np.repeat(self.surfaces, self.counts)

    def only(self, chosen: NDArray[np.bool_]) -> Elements:
        """Some of the panels (N,)."""
        kept = np.repeat(chosen, self.counts)
        first = np.concatenate([[0], np.cumsum(self.counts[chosen])])
        return Elements(self.panels[chosen], self.surfaces[chosen], first, self.segments[kept])


def cut_walls(geometry: Geometry, size: float, chosen: NDArray[np.bool_]) -> Elements:
    """Both sides of the chosen walls (S,) in elements of at most `size` cells.

    Panels end where another wall touches or crosses, elements also where the shadow of a wall's
    end in the light of a point or a parallel beam falls, so that light does not jump on an
    element. Where walls lie on one another, the earlier one counts.
    """
    edges = _shadow_edges(geometry)
    panels, surfaces, cuts = [], [], []
    for k in np.flatnonzero(chosen):
        others = np.delete(geometry.walls, k, axis=0)
        for piece in uncovered(geometry.walls[k], geometry.walls[:k]):
            for panel in _between(piece, _crossings(piece, others)):
                found = _cuts(panel, edges, size)
                panels += [panel, panel[[2, 3, 0, 1]]]
                surfaces += 2 * [geometry.surfaces[k]]
                cuts += [found, (1 - found)[::-1]]
    segments = [_between(panel, found) for panel, found in zip(panels, cuts)]
    first = np.cumsum([0, *map(len, segments)])
    return Elements(
        np.array(panels).reshape(-1, 4),
        np.array(surfaces, np.int64),
        first,
        np.concatenate([np.empty((0, 4)), *segments]),
    )


def _between(panel: Array, cuts: Array) -> Array:
    """Elements (K, 4) between cuts (K + 1,), from 0 to 1 along a panel (4,)."""
    ends = panel[:2] + cuts[:, None] * (panel[2:] - panel[:2])
    ends[-1] = panel[2:]
    return np.hstack([ends[:-1], ends[1:]])


def _crossings(piece: Array, others: Array) -> Array:
    """Where others touch or cross a piece (4,), from 0 to 1 along it, both included."""
    extent = piece[2:] - piece[:2]
    length = np.hypot(*extent)
    ends = others.reshape(-1, 2, 2) - piece[:2]
    distance = (ends @ [-extent[1], extent[0]]) / length
    a, b = np.where(np.abs(distance) <= TOUCH, 0.0, distance).T
    met = (a * b <= 0) & (a != b)
    share = a[met] / (a[met] - b[met])
    places = np.einsum("ijk,k->ij", ends[met], extent) / length**2
    return _distinct(places[:, 0] + share * (places[:, 1] - places[:, 0]), TOUCH / length)


def _cuts(panel: Array, edges: Array, size: float) -> Array:
    """Where to cut a panel, from 0 to 1: at shadow edges (M, 2) and evenly between them."""
    extent = panel[2:] - panel[:2]
    length = np.hypot(*extent)
    offset = edges - panel[:2]
    on_panel = np.abs(offset @ [-extent[1], extent[0]]) <= TOUCH * length
    stops = _distinct(offset[on_panel] @ extent / length**2, SHORTEST / length)
    parts = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) * length / size - TOUCH))), endpoint=False)
        for a, b in pairwise(stops)
    ]
    return np.concatenate([*parts, [1.0]])


def _distinct(places: Array, gap: float) -> Array:
    """0, those places between that are farther than `gap` from the one before and from 1, 1."""
    kept = [0.0]
    for place in np.sort(places).tolist():
        if kept[-1] + gap < place < 1 - gap:
            kept.append(place)
    return np.array([*kept, 1.0])


def _shadow_edges(geometry: Geometry) -> Array:
    """Where the shadows (M, 2) of wall ends in point and parallel light fall on walls."""
    ends = np.unique(geometry.walls.reshape(-1, 2), axis=0)
    found = [np.empty((0, 2))]
    ways = [ends - position for position in geometry.positions]
    ways += [np.broadcast_to(direction, ends.shape) for direction in geometry.directions]
    for way in ways:
        lengths = np.hypot(*way.T)
        unit = way / np.where(lengths > TOUCH, lengths, 1.0)[:, None]
        hits = hit_distances(ends, unit, geometry.walls)
        nearest = np.where(hits > TOUCH, hits, np.inf).min(axis=1, initial=np.inf)
        shaded = np.isfinite(nearest) & (lengths > TOUCH)
        found.append(ends[shaded] + nearest[shaded, None] * unit[shaded])
    return np.concatenate(found)
