"""How a light sees facets: polygons in a plane across its rays, and nearness over them.

A ray is (u, v, 1) in the frame of a view: its direction from a point light through one face of a
cube, at distance 1; for parallel light the place (u, v) where it passes a plane across it. In both
the nearness of a facet is linear in the ray, n·ω/d at distance d from a point light and minus the
way along parallel light: as in 2D (views.py), so that a line parts the rays on which one facet is
nearer than another. So does the border of a cell on a facet, as the ratio of two linear functions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.moved_segments import ON_BORDER
from flatland.shadow_map.outlines import Outlines, plane_frame
from flatland.shadow_map.views import EDGE_ON

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Cell index that stands for "found from the place".
ANY_CELL = np.iinfo(np.int64).min


@dataclass(frozen=True, eq=False)
class FacetView:
    """R convex outlines as one light sees them through one window; lengths in cells.

    corners: (T, 2), of which first[r] … first[r + 1] - 1 are outline r's, counter-clockwise.
    lines: (T, 3), the line from each to the next, its product with a ray is the distance to the
    left. facets: (R,) place of each in the scene. normals: (R, 3), towards the light. nearness:
    (R, 3), its product with a ray is greater the nearer the facet, and positive. places (R, 3, 3)
    and scales (R, 3): the point half a cell before the facet, along axis i, is the product of
    places[i] and a ray over that of scales. front: (R, 3), the cell before a facet that lies
    on the border of two after that move, along the axis across it; else ANY_CELL.
    axes: (3, 3), whose product with a ray is the direction of a ray of a point light. low, high:
    (2,), the rectangle of the map. window: (W, 2), the convex part of it that light comes
    through, counter-clockwise. angular: whether areas of the plane count by their solid angle.
    """

    corners: Array
    first: Indices
    lines: Array
    facets: Indices
    normals: Array
    nearness: Array
    places: Array
    scales: Array
    front: Indices
    axes: Array
    low: Array
    high: Array
    window: Array
    angular: bool

    @property
    def window_lines(self) -> Array:
        """The window's edges, (W, 3)."""
        return edge_lines(self.window, np.array([0, len(self.window)]))

    def points(self, rows: Indices, rays: Array) -> Array:
        """Where rays (K, 3) meet the facets of rows (K,), in cells (K, 3)."""
        moved = np.einsum("kij,kj->ki", self.places[rows], rays)
        scale = np.einsum("kj,kj->k", self.scales[rows], rays)
        return np.asarray(moved / scale[:, None] - 0.5 * self.normals[rows])

    def cosines(self, rows: Indices, rays: Array) -> Array:
        """|n·ω| of rays (K, 3) and facets of rows (K,)."""
        if self.angular:
            ways = rays @ self.axes.T
            ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        else:
            ways = np.broadcast_to(self.axes[:, 2], rays.shape)
        return np.asarray(np.minimum(1.0, np.abs(np.sum(self.normals[rows] * ways, axis=1))))


def point_views(outlines: Outlines, position: Array) -> list[FacetView]:
    """What a point light (3,) [cells] sees through the six faces of a cube round it."""
    seen = outlines._replace(vertices=outlines.vertices - position)
    heights = np.sum(seen.vertices[seen.first[:-1]] * seen.normals, axis=1)
    sizes = np.sqrt(np.maximum.reduceat(np.sum(seen.vertices**2, axis=1), seen.first[:-1]))
    seen, heights = _chosen(seen, heights, np.abs(heights) > EDGE_ON * sizes)
    return [_through_face(seen, heights, position, axis, s) for axis in range(3) for s in (-1, 1)]


def _through_face(
    seen: Outlines, heights: Array, position: Array, axis: int, sign: int
) -> FacetView:
    """One face of the cube; heights (R,) of the facets' planes along their normals."""
    axes = np.roll(np.eye(3), axis + 1, axis=0).T  # columns: two axes across, the axis itself
    axes[:, 2] *= sign
    # The frustum, |u| and |v| up to w, in world axes.
    planes = np.array([[1, 0, 1], [-1, 0, 1], [0, 1, 1], [0, -1, 1]]) @ axes.T
    number = Outlines(seen.vertices, seen.first, np.arange(len(heights)), seen.normals)
    inside = number.clipped(np.column_stack([planes, np.zeros(4)]))
    row = inside.facets
    normals, heights = inside.normals, heights[row]
    local = inside.vertices @ axes
    corners = local[:, :2] / local[:, 2:]
    nearness = (normals @ axes) / heights[:, None]
    normals = normals * -np.sign(heights)[:, None]
    places = axes + (position + 0.5 * normals)[:, :, None] * nearness[:, None]
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return _view(
        Outlines(corners, inside.first, seen.facets[row], normals),
        nearness,
        places,
        nearness,
        _front(inside._replace(vertices=inside.vertices + position, normals=normals)),
        axes,
        square,
        True,
    )


def parallel_view(outlines: Outlines, direction: Array, shape: tuple[int, ...]) -> FacetView:
    """What light along a unit vector (3,) sees from outside, through the grid's silhouette."""
    axes = plane_frame(direction).T
    slopes = outlines.normals @ direction
    heights = np.sum(outlines.vertices[outlines.first[:-1]] * outlines.normals, axis=1)
    kept = np.abs(slopes) > EDGE_ON
    outlines, heights = _chosen(outlines, heights, kept)
    slopes = slopes[kept]
    # Any way further than all that is in the grid makes nearness positive.
    furthest = 1.0 + 2.0 * float(np.sum(shape))
    nearness = (outlines.normals @ axes) / slopes[:, None]
    nearness[:, 2] = furthest - heights / slopes
    normals = outlines.normals * -np.sign(slopes)[:, None]
    upright = np.array([0.0, 0.0, 1.0])
    along = furthest * upright - nearness
    places = np.einsum("i,kj->kij", direction, along)
    places[:, :, :2] += axes[:, :2]
    places[:, :, 2] += 0.5 * normals
    corners = np.stack(np.meshgrid(*[(0, n) for n in shape], indexing="ij"), axis=-1)
    seen = shapely.MultiPoint(corners.reshape(-1, 3) @ axes[:, :2]).convex_hull
    window = shapely.get_coordinates(shapely.orient_polygons(seen))[:-1]
    return _view(
        outlines._replace(vertices=outlines.vertices @ axes[:, :2], normals=normals),
        nearness,
        places,
        np.broadcast_to(upright, nearness.shape),
        _front(outlines._replace(normals=normals)),
        axes,
        window,
        False,
    )


def _view(
    flat: Outlines,
    nearness: Array,
    places: Array,
    scales: Array,
    front: Indices,
    axes: Array,
    window: Array,
    angular: bool,
) -> FacetView:
    """flat: outlines whose vertices are those of the map (T, 2), running either way."""
    corners = _counter_clockwise(flat.vertices, flat.first)
    return FacetView(
        corners,
        flat.first,
        edge_lines(corners, flat.first),
        flat.facets,
        flat.normals,
        # Arrays of one layout, so that kernels are compiled once.
        np.ascontiguousarray(nearness),
        np.ascontiguousarray(places),
        np.ascontiguousarray(scales),
        front,
        axes,
        window.min(axis=0),
        window.max(axis=0),
        window,
        angular,
    )


def _chosen(outlines: Outlines, heights: Array, kept: NDArray[np.bool_]) -> tuple[Outlines, Array]:
    """Those outlines alone, and their heights."""
    counts = np.diff(outlines.first)
    vertices = outlines.vertices[np.repeat(kept, counts)]
    first = np.concatenate([[0], np.cumsum(counts[kept])]).astype(np.int64)
    return Outlines(vertices, first, outlines.facets[kept], outlines.normals[kept]), heights[kept]


def _front(outlines: Outlines) -> Indices:
    """See FacetView; normals are those towards the light."""
    front = np.full(outlines.normals.shape, ANY_CELL)
    if not len(front):
        return front
    counts = np.diff(outlines.first)
    moved = outlines.vertices + 0.5 * np.repeat(outlines.normals, counts, axis=0)
    least = np.minimum.reduceat(moved, outlines.first[:-1])
    most = np.maximum.reduceat(moved, outlines.first[:-1])
    border = np.rint(least)
    lies = np.maximum(np.abs(least - border), np.abs(most - border)) <= ON_BORDER
    lies &= np.abs(outlines.normals) > 0.5
    front[lies] = (border - (outlines.normals < 0))[lies].astype(np.int64)
    return front


def following(first: Indices) -> Indices:
    """The place of the next corner of the same outline, for every corner (T,)."""
    counts = np.diff(first)
    row = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(row)) + 1
    return np.asarray(np.where(place < first[row + 1], place, first[row]))


def _counter_clockwise(corners: Array, first: Indices) -> Array:
    """Corners (T, 2) of outlines, those that run clockwise turned round."""
    if not len(corners):
        return corners
    counts = np.diff(first)
    row = np.repeat(np.arange(len(counts)), counts)
    arms = corners - corners[first[row]]
    after = arms[following(first)]
    areas = np.bincount(row, arms[:, 0] * after[:, 1] - arms[:, 1] * after[:, 0], len(counts))
    place = np.arange(len(row))
    mirrored = first[row] + first[row + 1] - 1 - place
    return np.asarray(corners[np.where(areas[row] < 0, mirrored, place)])


def edge_lines(corners: Array, first: Indices) -> Array:
    """Lines (T, 3) from each corner to the next; zero for corners in one place."""
    along = corners[following(first)] - corners
    length = np.hypot(*along.T)[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.where(length > 0, length, 1.0)
    lines = np.column_stack([normal, -np.sum(normal * corners, axis=1)])
    return np.ascontiguousarray(lines)
