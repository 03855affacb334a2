"""What a light sees of facets, tile by tile, cut exactly where the first surface changes.

The rays of a tile are a convex polygon. It is parted facet by facet, each time along lines: the
edges of the facet and, where another is seen so far, the line on which the two are equally near.
The parts always tile the tile, so that no flux is lost or counted twice, whatever rounding does.
What it costs: facets in a tile times parts of it. Facets that hide behind one that covers the
tile are left out, and the nearest come first.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from flatland.shadow_map.convex import ROOM, Polygons, copy, kernel, linear, roomier, split
from flatland.shadow_map.facet_views import FacetView
from flatland.shadow_map.nearest import SAME
from flatland.shadow_map.outlines import MOST_SIDES
from flatland.shadow_map.tiles import Tiles, tiles_of

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Of a map's size: what a line cuts off thinner than that stays on.
SLACK = 1e-13
#: Sides of stored parts; what has more is halved, so that being cut by a facet leaves it in ROOM.
MOST_STORED = 16
#: Facets in a tile beyond which it is looked at in FINER x FINER tiles, and how often in a row.
MOST_IN_TILE, FINER, DEEPEST = 128, 8, 3
#: Of these, the number that a facet meets in the mean from which on that would not help.
WIDE = 16


def visible_polygons(view: FacetView, count: int) -> Polygons:
    """The lit parts of count x count tiles; tags: row of the view, and tile."""
    rows = np.arange(len(view.facets))
    tiles = tiles_of(view, rows, view.low, (view.high - view.low) / count, count)
    parts = list(_seen_in(view, tiles))
    tags = np.concatenate([part.tags for part in parts])
    sides = np.concatenate([np.diff(part.first) for part in parts])
    vertices = np.concatenate([part.vertices for part in parts])
    return Polygons(vertices, np.concatenate([[0], np.cumsum(sides)]), tags)


def _seen_in(view: FacetView, tiles: Tiles, depth: int = 0) -> Iterator[Polygons]:
    """Lit parts of tiles; those with many small facets are looked at in finer ones."""
    listed = np.diff(tiles.starts)
    crowded = np.flatnonzero(listed > MOST_IN_TILE) if depth < DEEPEST else listed[:0]
    finer = {int(tile): tiles.finer(view, int(tile), FINER) for tile in crowded}
    finer = {k: fine for k, fine in finer.items() if fine.members.size < WIDE * listed[k]}
    left_out = np.zeros(len(listed), bool)
    left_out[list(finer)] = True
    vertices, tags = _visible(
        view.first,
        view.lines,
        view.facets,
        view.nearness,
        np.empty((0, 3)) if view.angular else view.window_lines,
        tiles.low,
        tiles.size,
        tiles.starts,
        tiles.members,
        left_out,
        slack_of(view),
    )
    yield Polygons(vertices, np.append(0, tags[:, 0]), np.ascontiguousarray(tags[:, 1:]))
    for tile, fine in finer.items():
        for part in _seen_in(view, fine, depth + 1):
            whose = np.full(len(part.tags), tile)
            yield part._replace(tags=np.column_stack([part.tags[:, 0], whose]))


def slack_of(view: FacetView) -> float:
    """Width in the map below which a cut leaves a polygon whole."""
    return SLACK * float(np.abs([view.low, view.high]).max())


@kernel
def _visible(
    first: Indices,
    lines: Array,
    facets: Indices,
    nearness: Array,
    window: Array,
    low: Array,
    size: Array,
    starts: Indices,
    members: Indices,
    left_out: NDArray[np.bool_],
    slack: float,
) -> tuple[Array, Indices]:
    """Vertices of lit parts, and of each its end in them, row and tile."""
    count = int(np.sqrt(starts.size - 1) + 0.5)
    vertices, tags = np.empty((4096, 2)), np.empty((1024, 3), np.int64)
    used, corners = 0, 0
    shapes, parts = np.empty((64 * ROOM, 2)), np.empty((64, 2), np.int64)
    work = np.empty((3, ROOM, 2))
    for tile in range(starts.size - 1):
        if left_out[tile] or starts[tile] == starts[tile + 1]:
            continue
        sides = _rays_of_tile(tile, count, low, size, window, slack, work)
        if sides < 3:
            continue
        listed = _nearest_first(
            work[0], sides, members[starts[tile] : starts[tile + 1]], first, lines, nearness, slack
        )
        total = _store(work[0], sides, -1, shapes, parts, 0)
        for row in listed:
            needed = total * (2 * MOST_SIDES + 5)
            parts = roomier(parts, total, needed)
            shapes = roomier(shapes, total * ROOM, needed * ROOM)
            total = _insert(row, first, lines, facets, nearness, slack, shapes, parts, total, work)
        for part in range(total):
            if parts[part, 1] >= 0 and parts[part, 0] > 2:
                vertices = roomier(vertices, corners, corners + ROOM)
                tags = roomier(tags, used, used + 1)
                begin = part * ROOM
                corners = copy(shapes, begin, begin + parts[part, 0], vertices, corners)
                tags[used, 0], tags[used, 1], tags[used, 2] = corners, parts[part, 1], tile
                used += 1
    return vertices[:corners], tags[:used]


@kernel
def _rays_of_tile(
    tile: int, count: int, low: Array, size: Array, window: Array, slack: float, work: Array
) -> int:
    """The part of a tile that light comes through, in work[0], and its number of sides."""
    for corner in range(4):
        work[0, corner, 0] = low[0] + size[0] * (tile // count + (0 < corner < 3))
        work[0, corner, 1] = low[1] + size[1] * (tile % count + (corner > 1))
    sides = 4
    for k in range(window.shape[0]):
        sides, _ = split(work[0], sides, window[k], slack, work[1], work[2])
        copy(work[1], 0, sides, work[0], 0)
    return sides


@kernel
def _nearest_first(
    polygon: Array,
    count: int,
    listed: Indices,
    first: Indices,
    lines: Array,
    nearness: Array,
    slack: float,
) -> Indices:
    """Facets that are not hidden all over by one that covers the polygon, the nearest first."""
    rows, keys = np.empty(listed.size, np.int64), np.empty((listed.size, 2))
    cover, found = 0.0, 0
    for k, row in enumerate(listed):
        least, most, total = np.inf, -np.inf, 0.0
        for i in range(count):
            near = linear(nearness[row], polygon[i])
            least, most, total = min(least, near), max(most, near), total + near
        if least > cover and _covers(first[row], first[row + 1], lines, polygon, count, slack):
            cover = least
        place = k
        while place and keys[place - 1, 0] < total:
            rows[place] = rows[place - 1]
            keys[place, 0], keys[place, 1] = keys[place - 1, 0], keys[place - 1, 1]
            place -= 1
        rows[place], keys[place, 0], keys[place, 1] = row, total, most
    for k in range(listed.size):
        if keys[k, 1] >= cover * (1.0 - SAME):
            rows[found] = rows[k]
            found += 1
    return rows[:found]


@kernel
def _covers(begin: int, end: int, lines: Array, polygon: Array, count: int, slack: float) -> bool:
    for edge in range(begin, end):
        for i in range(count):
            if linear(lines[edge], polygon[i]) < -slack:
                return False
    return True


@kernel
def _misses(begin: int, end: int, lines: Array, polygon: Array, count: int, slack: float) -> bool:
    """Whether one of the edges has all of a polygon outside."""
    for edge in range(begin, end):
        # The line of an edge without length is zero.
        outside = lines[edge, 0] != 0.0 or lines[edge, 1] != 0.0
        for i in range(count):
            outside = outside and linear(lines[edge], polygon[i]) <= slack
        if outside:
            return True
    return False


@kernel
def _insert(
    row: int,
    first: Indices,
    lines: Array,
    facets: Indices,
    nearness: Array,
    slack: float,
    shapes: Array,
    parts: Indices,
    total: int,
    work: Array,
) -> int:
    """Part a tile by one more facet; the number of parts.

    shapes: ROOM rows of vertices for each part. parts: (M, 2), the number of its sides, and the row
    that it shows or -1. Parts that are cut stay in the list without sides.
    """
    begin, end = first[row], first[row + 1]
    line = np.empty(3)
    for part in range(total):
        count, owner = parts[part, 0], parts[part, 1]
        if count < 3:
            continue
        copy(shapes, part * ROOM, part * ROOM + count, work[0], 0)
        nearer = 1
        if owner >= 0:
            wins = facets[row] < facets[owner]
            nearer = _nearer(work[0], count, nearness[row], nearness[owner], wins)
        if nearer < 0 or _misses(begin, end, lines, work[0], count, slack):
            continue
        parts[part, 0] = 0
        for edge in range(begin, end):
            count, total = _keep_left(work, count, lines[edge], slack, owner, shapes, parts, total)
        if nearer == 0:
            for k in range(3):
                line[k] = nearness[row, k] - nearness[owner, k]
            size = np.hypot(line[0], line[1])
            for k in range(3):
                line[k] /= size
            count, total = _keep_left(work, count, line, slack, owner, shapes, parts, total)
        total = _store(work[0], count, row, shapes, parts, total)
    return total


@kernel
def _keep_left(
    work: Array,
    count: int,
    line: Array,
    slack: float,
    owner: int,
    shapes: Array,
    parts: Indices,
    total: int,
) -> tuple[int, int]:
    """Cut the polygon in work[0] and store what lies right of a line; its sides, all parts."""
    count, rest = split(work[0], count, line, slack, work[1], work[2])
    total = _store(work[2], rest, owner, shapes, parts, total)
    copy(work[1], 0, count, work[0], 0)
    return count, total


@kernel
def _nearer(polygon: Array, count: int, one: Array, other: Array, wins: bool) -> int:
    """Whether a facet is nearer than another: 1 all over a polygon, -1 nowhere, 0 in parts.

    wins: the answer where both lie in one place.
    """
    least, most, size = np.inf, -np.inf, 0.0
    for i in range(count):
        a, b = linear(one, polygon[i]), linear(other, polygon[i])
        least, most = min(least, a - b), max(most, a - b)
        size = max(size, abs(a), abs(b))
    if most <= SAME * size:
        return 1 if wins and least >= -SAME * size else -1
    return 1 if least >= -SAME * size else 0


@kernel
def _store(
    polygon: Array, count: int, owner: int, shapes: Array, parts: Indices, total: int
) -> int:
    """Append a part, in halves if it has many sides; the number of parts."""
    if count < 3:
        return total
    half = count // 2 if count > MOST_STORED else count - 1
    end = copy(polygon, 0, half + 1, shapes, total * ROOM)
    parts[total, 0], parts[total, 1] = half + 1, owner
    if half + 1 == count:
        return total + 1
    end = copy(polygon, half, count, shapes, (total + 1) * ROOM)
    copy(polygon, 0, 1, shapes, end)
    parts[total + 1, 0], parts[total + 1, 1] = count - half + 1, owner
    return total + 2
