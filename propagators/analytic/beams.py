"""Intensity of every cell in one direction: exact in space, by parallel projection.

In a fixed direction ω every ray has a place across, p = -x ω_y + y ω_x, and places along it,
t = x ω_x + y ω_y. A face and an emitter overlap in an interval of p; walls between them take
intervals out of it, and what is left, times the radiance, is the flux per angle through the face
(numerics §1). Nothing here is shared with the crossed strings, so that each can check the other.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH
from propagators.analytic.compiling import inner, share_work, shared

Vector = NDArray[np.float64]

#: Narrower than this across, a segment or face is seen edge-on.
EDGE_ON = 1e-12


def beam_intensity(
    shape: tuple[int, int], directions: Vector, emitters: Vector, radiance: Vector, walls: Vector
) -> Vector:
    """Intensity (K, C, nx, ny) at unit directions (K, 2) from emitters (E, 4), radiance (E, C)."""
    result = np.zeros((len(directions), radiance.shape[1], *shape))
    count = len(directions) * shape[0] * shape[1]
    share_work(_project, count, directions, emitters, radiance, walls, result)
    return result


@shared
def _project(
    party: int,
    parties: int,
    directions: Vector,
    emitters: Vector,
    radiance: Vector,
    walls: Vector,
    result: Vector,
) -> None:
    for k in range(party, directions.shape[0], parties):
        _one_direction(directions[k, 0], directions[k, 1], emitters, radiance, walls, result[k])


@inner
def _one_direction(
    wx: float, wy: float, emitters: Vector, radiance: Vector, walls: Vector, result: Vector
) -> None:
    blockers = turned_rows(wx, wy, walls)
    lights = turned_rows(wx, wy, emitters)
    face = np.empty(4)
    hidden = np.empty((2, walls.shape[0] + 1))
    step_x, step_y = (1 if wx > 0 else 0), (1 if wy > 0 else 0)
    reach = 0.5 * (abs(wx) + abs(wy)) + TOUCH
    for e in range(emitters.shape[0]):
        # Emitters light their left: from the rear, start is seen at the larger p.
        light = lights[e]
        if light[0] - light[2] <= EDGE_ON:
            continue
        for i in range(result.shape[1]):
            for j in range(result.shape[2]):
                # Most cells lie beside the beam of a light, and there may be many lights.
                middle = (j + 0.5) * wx - (i + 0.5) * wy
                if middle + reach < light[2] or middle - reach > light[0]:
                    continue
                seen = 0.0
                if abs(wx) > EDGE_ON:
                    _place_face(face, wx, wy, i + step_x, j, 0, 1)
                    seen += seen_width(face, light, blockers, hidden, TOUCH)
                if abs(wy) > EDGE_ON:
                    _place_face(face, wx, wy, i, j + step_y, 1, 0)
                    seen += seen_width(face, light, blockers, hidden, TOUCH)
                for colour in range(radiance.shape[1]):
                    result[colour, i, j] += radiance[e, colour] * seen


@inner
def turned_rows(wx: float, wy: float, segments: Vector) -> Vector:
    """Rows (p, t, p, t) of both ends of segments (S, 4)."""
    turned = np.empty(segments.shape)
    for s in range(segments.shape[0]):
        for end in range(2):
            x, y = segments[s, 2 * end], segments[s, 2 * end + 1]
            turned[s, 2 * end] = y * wx - x * wy
            turned[s, 2 * end + 1] = x * wx + y * wy
    return turned


@inner
def _place_face(face: Vector, wx: float, wy: float, x: int, y: int, dx: int, dy: int) -> None:
    """Face from (x, y) to (x + dx, y + dy) as (p, t, p, t), smaller p first."""
    first, second = (0, 2) if dy * wx - dx * wy > 0 else (2, 0)
    face[first], face[first + 1] = y * wx - x * wy, x * wx + y * wy
    x, y = x + dx, y + dy
    face[second], face[second + 1] = y * wx - x * wy, x * wx + y * wy


@inner
def _along(row: Vector, p: float) -> float:
    """Place along the ray p at which it meets a segment (p, t, p, t)."""
    return row[1] + (p - row[0]) / (row[2] - row[0]) * (row[3] - row[1])


@inner
def _overlap(
    low: float, high: float, at_low: float, at_high: float, touch: float
) -> tuple[float, float]:
    """The part of [low, high] where a function, at_low to at_high, exceeds `touch`."""
    at_low, at_high = at_low - touch, at_high - touch
    if max(at_low, at_high) <= 0.0:
        return high, high
    zero = low + (high - low) * (at_low / (at_low - at_high)) if at_low != at_high else low
    return (zero if at_low < 0.0 else low), (zero if at_high < 0.0 else high)


@inner
def seen_width(
    face: Vector, light: Vector, blockers: Vector, hidden: Vector, touch: float
) -> float:
    """Width across of what the light sends through the face past the blockers.

    touch: what is nearer to one another than this hides nothing.
    """
    low, high = max(face[0], light[2]), min(face[2], light[0])
    if low >= high:
        return 0.0
    from_light = _along(light, low), _along(light, high)
    to_face = _along(face, low), _along(face, high)
    start, stop = _overlap(low, high, to_face[0] - from_light[0], to_face[1] - from_light[1], touch)
    if start >= stop:
        return 0.0
    count = 0
    for k in range(blockers.shape[0]):
        blocker = blockers[k]
        a, b = max(start, min(blocker[0], blocker[2])), min(stop, max(blocker[0], blocker[2]))
        if a >= b or abs(blocker[2] - blocker[0]) <= EDGE_ON:
            continue
        behind = _along(blocker, a), _along(blocker, b)
        a1, b1 = _overlap(a, b, behind[0] - _along(light, a), behind[1] - _along(light, b), touch)
        a2, b2 = _overlap(a, b, _along(face, a) - behind[0], _along(face, b) - behind[1], touch)
        a, b = max(a1, a2), min(b1, b2)
        if a < b:
            place = count
            while place > 0 and hidden[0, place - 1] > a:
                hidden[0, place], hidden[1, place] = hidden[0, place - 1], hidden[1, place - 1]
                place -= 1
            hidden[0, place], hidden[1, place] = a, b
            count += 1
    return (stop - start) - _covered(hidden, count)


@inner
def _covered(hidden: Vector, count: int) -> float:
    """Length of the union of intervals that are sorted by their start."""
    total, reached = 0.0, -math.inf
    for k in range(count):
        total += max(0.0, hidden[1, k] - max(hidden[0, k], reached))
        reached = max(reached, hidden[1, k])
    return total


@shared
def ray_intensity(
    shape: tuple[int, int], directions: Vector, positions: Vector, strength: Vector, walls: Vector
) -> Vector:
    """Intensity (K, C, nx, ny) from point sources: each ray counts in every cell that it leaves.

    strength: (K, P, C) intensity of the points (P, 2) in each direction.
    """
    result = np.zeros((directions.shape[0], strength.shape[2], shape[0], shape[1]))
    for k in range(directions.shape[0]):
        blockers = turned_rows(directions[k, 0], directions[k, 1], walls)
        for s in range(positions.shape[0]):
            _trace(positions[s], directions[k], blockers, strength[k, s], result[k])
    return result


@inner
def _trace(
    position: Vector, direction: Vector, blockers: Vector, strength: Vector, result: Vector
) -> None:
    """Adds strength (C,) to the cells whose border a ray crosses on its way to the first wall."""
    wx, wy = direction[0], direction[1]
    p, t = position[1] * wx - position[0] * wy, position[0] * wx + position[1] * wy
    reach = math.inf
    for k in range(blockers.shape[0]):
        row = blockers[k]
        if min(row[0], row[2]) <= p < max(row[0], row[2]):
            hit = _along(row, p) - t
            if TOUCH < hit < reach:
                reach = hit
    for axis in range(2):
        speed = direction[axis]
        if abs(speed) <= EDGE_ON:
            continue
        forward = 1 if speed > 0 else -1
        for line in range(result.shape[1 + axis] + 1):
            way = (line - position[axis]) / speed
            if not TOUCH < way <= reach + TOUCH:
                continue
            across = math.floor(position[1 - axis] + way * direction[1 - axis])
            cell = line - 1 if forward > 0 else line
            if 0 <= across < result.shape[2 - axis] and 0 <= cell < result.shape[1 + axis]:
                i, j = (cell, across) if axis == 0 else (across, cell)
                for colour in range(strength.size):
                    result[colour, i, j] += strength[colour]
