"""What may stand between panels and all targets of a tile: walls that are looked at for each.

A wall outside the hull of a tile and a panel hides nothing of the one from the other, and one that
reaches from side to side of it hides all. Both are found once for a tile of some hundred targets,
which then look at what is left (see `shafts`, which does the same for one target, to the end).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH
from propagators.analytic.compiling import inner
from propagators.analytic.shafts import distance_to

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells along the side of a tile.
SIDE = 16


def tiles_of(targets: Vector) -> tuple[Counts, Counts]:
    """Groups of targets (G, P, 4) by tile: their numbers (G,), and where each tile begins."""
    middles = targets.reshape(len(targets), 2 * targets.shape[1], 2).mean(axis=1)
    corners = np.floor(middles / SIDE).astype(np.int64)
    _, tile = np.unique(corners, axis=0, return_inverse=True)
    order = np.argsort(tile.ravel(), kind="stable")
    starts = np.searchsorted(tile.ravel()[order], np.arange(tile.max(initial=-1) + 2))
    return order, starts


@inner
def bounds(targets: Vector, groups: Counts, box: Vector) -> None:
    """The smallest box (x, y, x, y) round some groups of targets."""
    box[0], box[1], box[2], box[3] = math.inf, math.inf, -math.inf, -math.inf
    for g in groups:
        for p in range(targets.shape[1]):
            for i in range(0, 4, 2):
                box[0], box[1] = min(box[0], targets[g, p, i]), min(box[1], targets[g, p, i + 1])
                box[2], box[3] = max(box[2], targets[g, p, i]), max(box[3], targets[g, p, i + 1])


@inner
def keep_for_box(
    box: Vector, panel: Vector, parts: Vector, count: int, strings: Vector, kept: Vector
) -> int:
    """Those of `parts` (front of the panel) that may hide it from a box; their number.

    -1 if nothing of the panel reaches the box. strings: work space (2, 4).
    """
    ahead = -math.inf
    for corner in range(4):
        x, y = box[2 * (corner & 1)], box[1 + (corner & 2)]
        ahead = max(ahead, distance_to(panel, x, y))
    if ahead <= TOUCH:
        return -1
    found = _strings(box, panel, strings)
    low_x, high_x = min(box[0], panel[0], panel[2]), max(box[2], panel[0], panel[2])
    low_y, high_y = min(box[1], panel[1], panel[3]), max(box[3], panel[1], panel[3])
    number = 0
    for k in range(count):
        wall = parts[k]
        if max(wall[0], wall[2]) < low_x - TOUCH or min(wall[0], wall[2]) > high_x + TOUCH:
            continue
        if max(wall[1], wall[3]) < low_y - TOUCH or min(wall[1], wall[3]) > high_y + TOUCH:
            continue
        if found & 1 and _beyond(strings[0], wall, 1.0):
            continue
        if found & 2 and _beyond(strings[1], wall, -1.0):
            continue
        crosses = found == 3 and _crosses(strings[0], wall) and _crosses(strings[1], wall)
        if crosses and _parts(wall, box, panel):
            return -1
        kept[number] = wall
        number += 1
    return number


@inner
def _strings(box: Vector, panel: Vector, strings: Vector) -> int:
    """The sides of the hull from the box to the panel: all lies to the left of strings[0], and to
    the right of strings[1]. Bits: which of them there are."""
    found = 0
    line = np.empty(4)
    for corner in range(4):
        for end in range(0, 4, 2):
            line[0], line[1] = box[2 * (corner & 1)], box[1 + (corner & 2)]
            line[2], line[3] = panel[end], panel[end + 1]
            if math.hypot(line[2] - line[0], line[3] - line[1]) <= TOUCH:
                continue
            low = min(0.0, distance_to(line, panel[2 - end], panel[3 - end]))
            high = max(0.0, distance_to(line, panel[2 - end], panel[3 - end]))
            for other in range(4):
                x, y = box[2 * (other & 1)], box[1 + (other & 2)]
                distance = distance_to(line, x, y)
                low, high = min(low, distance), max(high, distance)
            if low >= 0.0 and high > TOUCH:
                strings[0] = line
                found |= 1
            elif high <= 0.0 and low < -TOUCH:
                strings[1] = line
                found |= 2
    return found


@inner
def _beyond(string: Vector, wall: Vector, left: float) -> bool:
    """Whether a wall lies on the other side of a string than all else."""
    first = left * distance_to(string, wall[0], wall[1])
    return max(first, left * distance_to(string, wall[2], wall[3])) < -TOUCH


@inner
def _crosses(string: Vector, wall: Vector) -> bool:
    """Whether a wall goes through a string, between its ends and its own."""
    if math.hypot(wall[2] - wall[0], wall[3] - wall[1]) <= TOUCH:
        return False
    a, b = distance_to(string, wall[0], wall[1]), distance_to(string, wall[2], wall[3])
    c, d = distance_to(wall, string[0], string[1]), distance_to(wall, string[2], string[3])
    return min(a, b) < -TOUCH < TOUCH < max(a, b) and min(c, d) < -TOUCH < TOUCH < max(c, d)


@inner
def _parts(wall: Vector, box: Vector, panel: Vector) -> bool:
    """Whether the whole panel lies behind a wall's line, seen from the whole box."""
    a, b = distance_to(wall, panel[0], panel[1]), distance_to(wall, panel[2], panel[3])
    low, high = min(a, b), max(a, b)
    for corner in range(4):
        distance = distance_to(wall, box[2 * (corner & 1)], box[1 + (corner & 2)])
        if not (distance < -TOUCH < TOUCH < low or distance > TOUCH > -TOUCH > high):
            return False
    return True
