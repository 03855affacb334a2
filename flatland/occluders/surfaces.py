"""Surfaces made of triangles: whether they close, and which side is out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flatland.planar import ROUNDING, THIN

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

#: Of its area times its size: a body of less volume has no inside.
FLAT = 1e-12
#: Angle [rad] between neighbours below which they lie on each other.
FOLD = 1e-4
AGAIN = "that are there already (a wall is opaque from both sides)"
#: What becomes of a polygon that is not convex when it is cut into a fan.
FOLDED = (
    "that lie flat on their neighbour (polygons that are not convex must be split into triangles "
    "by the program that writes the file)"
)

UNCLEAR = (
    "has edges where more than two triangles meet, and no clear inside; keep bodies that touch in "
    "files of their own, or take it as thin walls with open = true"
)


class SurfaceError(Exception):
    """A surface breaks a rule; the message is the rule."""


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of triangles, corners in the same place being one vertex.

    vertices: (T, 3), the vertex of each corner. numbers: (T, 3), the edge from each corner to the
    next. forwards: (T, 3), whether it runs from the lower vertex to the higher. uses: (E,), how
    many triangles have each edge.
    """

    vertices: Indices
    numbers: Indices
    forwards: Flags
    uses: Indices

    def shared(self) -> Indices:
        """Triangle and corner of both uses of every edge that two triangles have, (P, 2, 2)."""
        order = np.argsort(self.numbers, axis=None, kind="stable")
        pairs = order[self.uses[self.numbers.ravel()[order]] == 2].reshape(-1, 2)
        return np.stack(np.divmod(pairs, 3), axis=-1)


def edges_of(triangles: Array) -> Edges:
    """Of triangles (T, 3, 3). Corners are in the same place if their coordinates are equal."""
    points = triangles.reshape(-1, 3) + 0.0  # no negative zeros
    order = np.lexsort(points.T)
    steps = np.any(np.diff(points[order], axis=0) != 0, axis=1)
    names = np.empty(len(points), np.int64)
    names[order] = np.concatenate([[0], np.cumsum(steps)])
    vertices = names.reshape(-1, 3)
    following = np.roll(vertices, -1, axis=1)
    low, high = np.minimum(vertices, following), np.maximum(vertices, following)
    _, numbers, uses = np.unique(
        low * (len(points) + 1) + high, return_inverse=True, return_counts=True
    )
    return Edges(vertices, numbers.reshape(-1, 3), vertices < following, uses)


def check_triangles(triangles: Array, edges: Edges) -> None:
    """Raise SurfaceError for triangles without area, repeated, or folded onto each other."""
    size = float(np.abs(triangles - triangles[0, 0]).max()) or 1.0
    scaled = (triangles - triangles[0, 0]) / size  # squares neither overflow nor underflow
    sides = np.roll(scaled, -1, axis=1) - scaled
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    rounding = ROUNDING * float(np.abs(triangles).max()) / size
    thin = area <= np.maximum(THIN * longest, rounding) * longest
    _refuse(triangles, np.flatnonzero(thin), "without area")
    _, first, place = np.unique(
        np.sort(edges.vertices, axis=1), axis=0, return_index=True, return_inverse=True
    )
    again = np.flatnonzero(first[place.ravel()] != np.arange(len(triangles)))
    _refuse(triangles, again, AGAIN)
    _refuse(triangles, _folded(scaled, edges), FOLDED)


def outward(triangles: Array, edges: Edges) -> Array:
    """The triangles, each with corners counter-clockwise seen from outside its body.

    A body is what hangs together by edges that two triangles share; each has its own outside, so
    that the inner one of two nested boxes is a box too. How the corners ran before does not matter.
    Raises SurfaceError if the surface is open, has one side only, or encloses nothing.
    """
    lonely = np.flatnonzero(edges.uses % 2)
    if lonely.size:
        place = np.argwhere(edges.numbers == lonely[0])[0]
        ends = triangles[place[0], [place[1], (place[1] + 1) % 3]]
        where = f"the first from {_shown(ends[0])} to {_shown(ends[1])}"
        advice = "close it, or take it as thin walls with open = true"
        count = f"{lonely.size} of its edges have no second triangle"
        raise SurfaceError(f"is open: {count}, {where}; {advice}")
    turned, body = _wound(edges)
    turned = turned ^ _inside_out(_flipped(triangles, turned), body)[body]
    return _flipped(triangles, turned)


def _refuse(triangles: Array, found: Indices, what: str) -> None:
    if found.size:
        where = _shown(triangles[found[0], 0])
        count = f"{found.size} of {len(triangles)}, the first is number {found[0] + 1} at {where}"
        raise SurfaceError(f"has triangles {what}: {count}")


def _folded(triangles: Array, edges: Edges) -> Indices:
    """Triangles that lie on the neighbour with which they share an edge."""
    pairs = edges.shared()
    start = triangles[pairs[..., 0], pairs[..., 1]]
    stop = triangles[pairs[..., 0], (pairs[..., 1] + 1) % 3]
    tip = triangles[pairs[..., 0], (pairs[..., 1] + 2) % 3] - start
    along = stop - start
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    # At right angles to the edge, from it into each triangle.
    inward = tip - np.sum(tip * along, axis=-1, keepdims=True) * along
    inward /= np.linalg.norm(inward, axis=-1, keepdims=True)
    apart = np.linalg.norm(inward[:, 0] - inward[:, 1], axis=-1)
    return np.unique(pairs[apart <= FOLD, 1, 0])


def _wound(edges: Edges) -> tuple[Flags, Indices]:
    """Triangles to turn round so that neighbours agree, and the body of each, (T,) both.

    Every triangle is there twice, as it is and turned; the two that agree across an edge hang
    together. A body falls into two halves, either of which will do.
    """
    count, pairs = len(edges.numbers), edges.shared()
    one, other = pairs[:, 0, 0], pairs[:, 1, 0]
    forwards = edges.forwards[pairs[..., 0], pairs[..., 1]]
    clash = count * (forwards[:, 0] == forwards[:, 1])
    links = (
        np.concatenate([one, one + count]),
        np.concatenate([other + clash, other + count - clash]),
    )
    graph = coo_array((np.ones(links[0].size, bool), links), shape=(2 * count, 2 * count))
    _, labels = connected_components(graph, directed=False)
    same, turned = labels[:count], labels[count:]
    if np.any(same == turned):
        raise SurfaceError("has one side only, like a Möbius strip: it has no inside")
    _, body = np.unique(np.minimum(same, turned), return_inverse=True)
    flags = same > turned
    signs = np.where(edges.forwards ^ flags[:, None], 1, -1)
    key = edges.numbers * (int(body.max()) + 1) + body[:, None]
    _, place = np.unique(key, return_inverse=True)
    if np.any(np.bincount(place.ravel(), signs.ravel())):
        raise SurfaceError(UNCLEAR)
    return flags, body


def _inside_out(triangles: Array, body: Indices) -> Flags:
    """Per body, wound evenly, whether its triangles run clockwise seen from outside."""
    count = np.bincount(body)
    middle = [np.bincount(body, triangles.mean(axis=1)[:, axis]) / count for axis in range(3)]
    arms = triangles - np.stack(middle, axis=-1)[body][:, None]
    size = float(np.abs(arms).max())
    arms = arms / size
    vectors = np.cross(arms[:, 1] - arms[:, 0], arms[:, 2] - arms[:, 0])
    volume = np.bincount(body, np.sum(arms[:, 0] * vectors, axis=1)) / 6
    area = np.bincount(body, np.linalg.norm(vectors, axis=1)) / 2
    if np.any(np.abs(volume) <= FLAT * area):
        raise SurfaceError("has a part that encloses no volume")
    return np.asarray(volume < 0)


def _flipped(triangles: Array, flags: Flags) -> Array:
    return np.where(flags[:, None, None], triangles[:, ::-1], triangles)


def _shown(point: Array) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in point) + "]"
