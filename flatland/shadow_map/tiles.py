"""Which facets each tile of a map may see."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.shadow_map.convex import kernel, roomier
from flatland.shadow_map.facet_views import FacetView

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Of a tile: facets that come this close to one count as in it.
MARGIN = 1e-6


class Tiles(NamedTuple):
    """per_side x per_side rectangles, tile (i, j) being number i · per_side + j.

    low, size: (2,), the lower corner of the first and the sides of each. members: rows of the
    view's facets, those of tile t from starts[t] to starts[t + 1].
    """

    per_side: int
    low: Array
    size: Array
    starts: Indices
    members: Indices

    def finer(self, view: FacetView, tile: int, count: int) -> Tiles:
        """One tile as count x count tiles."""
        low = self.low + self.size * np.divmod(tile, self.per_side)
        rows = self.members[self.starts[tile] : self.starts[tile + 1]]
        return tiles_of(view, rows, low, self.size / count, count)


def tiles_of(view: FacetView, rows: Indices, low: Array, size: Array, count: int) -> Tiles:
    """Tiles over a part of a map; rows are found column by column, not tile by tile."""
    spans = _spans(view.corners, view.first, rows, low, size, count)
    starts, members = _listed(spans, count)
    return Tiles(count, low, size, starts, members)


@kernel
def _spans(
    corners: Array, first: Indices, rows: Indices, low: Array, size: Array, count: int
) -> Indices:
    """What each outline may meet: (row, column i, first j, last j), (M, 4)."""
    used, spans = 0, np.empty((1024, 4), np.int64)
    for row in rows:
        least, most = np.inf, -np.inf
        for k in range(first[row], first[row + 1]):
            u = (corners[k, 0] - low[0]) / size[0]
            least, most = min(least, u), max(most, u)
        if most < -MARGIN or least > count + MARGIN:
            continue
        for i in range(_tile(least - MARGIN, count), _tile(most + MARGIN, count) + 1):
            begin, end = low[0] + size[0] * (i - MARGIN), low[0] + size[0] * (i + 1 + MARGIN)
            bottom, top = _range_over(corners, first[row], first[row + 1], begin, end)
            bottom, top = (bottom - low[1]) / size[1], (top - low[1]) / size[1]
            if bottom > top or top < -MARGIN or bottom > count + MARGIN:
                continue
            spans = roomier(spans, used, used + 1)
            spans[used, 0], spans[used, 1] = row, i
            spans[used, 2] = _tile(bottom - MARGIN, count)
            spans[used, 3] = _tile(top + MARGIN, count)
            used += 1
    return spans[:used]


@kernel
def _tile(place: float, count: int) -> int:
    return min(max(int(np.floor(place)), 0), count - 1)


@kernel
def _range_over(
    corners: Array, first: int, end: int, left: float, right: float
) -> tuple[float, float]:
    """Least and greatest v of a polygon where left <= u <= right; (inf, -inf) where it is not."""
    low, high = np.inf, -np.inf
    for k in range(first, end):
        u, v = corners[k]
        other_u, other_v = corners[k + 1 if k + 1 < end else first]
        if left <= u <= right:
            low, high = min(low, v), max(high, v)
        for border in (left, right):
            if (u < border) != (other_u < border):
                crossing = v + (border - u) / (other_u - u) * (other_v - v)
                low, high = min(low, crossing), max(high, crossing)
    return low, high


@kernel
def _listed(spans: Indices, count: int) -> tuple[Indices, Indices]:
    starts = np.zeros(count * count + 1, np.int64)
    for k in range(spans.shape[0]):
        for j in range(spans[k, 2], spans[k, 3] + 1):
            starts[spans[k, 1] * count + j + 1] += 1
    for tile in range(count * count):
        starts[tile + 1] += starts[tile]
    members, place = np.empty(starts[-1], np.int64), starts[:-1].copy()
    for k in range(spans.shape[0]):
        for j in range(spans[k, 2], spans[k, 3] + 1):
            tile = spans[k, 1] * count + j
            members[place[tile]] = spans[k, 0]
            place[tile] += 1
    return starts, members
