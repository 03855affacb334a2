"""Parallel light through targets: exact in space, a single direction in angle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.beams import EDGE_ON, seen_width, turned_rows
from propagators.analytic.blockers import TOUCH
from propagators.analytic.compiling import inner, share_work, shared

Vector = NDArray[np.float64]


def collect_parallel_light(
    targets: Vector, directions: Vector, irradiances: Vector, walls: Vector, bands: int
) -> Vector:
    """Moments (G, C, 2 bands - 1) of parallel light through groups of targets (G, P, 4).

    Flux through the group times e^{imθ} of its one direction. directions: (D, 2) unit vectors.
    irradiances: (D, C), flux per cell length across. Targets are lit from their left; what the
    walls (S, 4) hide is an interval across the beam, as in `beams`.
    """
    result = np.zeros((len(targets), irradiances.shape[1], 2 * bands - 1))
    # The light comes from a line across the beam that lies before everything.
    reach = 1.0 + 2 * max(np.abs(targets).max(initial=0.0), np.abs(walls).max(initial=0.0))
    share_work(_collect, len(targets), targets, directions, irradiances, walls, reach, result)
    return result


@shared
def _collect(
    party: int,
    parties: int,
    targets: Vector,
    directions: Vector,
    irradiances: Vector,
    walls: Vector,
    reach: float,
    result: Vector,
) -> None:
    blockers, hidden = np.empty(walls.shape), np.empty((2, walls.shape[0] + 1))
    light, face = np.array([reach, -reach, -reach, -reach]), np.empty(4)
    for d in range(directions.shape[0]):
        wx, wy = directions[d, 0], directions[d, 1]
        turned = turned_rows(wx, wy, walls)
        for g in range(party, targets.shape[0], parties):
            width = 0.0
            for p in range(targets.shape[1]):
                target = targets[g, p]
                _turn(wx, wy, target, face)
                # Light that arrives on the left meets the target's start at the smaller place.
                if face[2] - face[0] > EDGE_ON:
                    count = _others(target, walls, turned, blockers)
                    width += seen_width(face, light, blockers[:count], hidden, 0.0)
            if width > 0.0:
                _add_direction(width, wx, wy, irradiances[d], result[g])


@inner
def _turn(wx: float, wy: float, target: Vector, face: Vector) -> None:
    for end in range(0, 4, 2):
        face[end] = target[end + 1] * wx - target[end] * wy
        face[end + 1] = target[end] * wx + target[end + 1] * wy


@inner
def _others(target: Vector, walls: Vector, turned: Vector, blockers: Vector) -> int:
    """Copies the turned walls that do not lie on the target's line; their number.

    Those that do hide nothing, but at grazing light rounding along the beam would say otherwise.
    """
    tx, ty = target[2] - target[0], target[3] - target[1]
    touch = TOUCH * math.sqrt(tx * tx + ty * ty)
    count = 0
    for s in range(walls.shape[0]):
        start = tx * (walls[s, 1] - target[1]) - ty * (walls[s, 0] - target[0])
        stop = tx * (walls[s, 3] - target[1]) - ty * (walls[s, 2] - target[0])
        if max(abs(start), abs(stop)) > touch:
            blockers[count] = turned[s]
            count += 1
    return count


@inner
def _add_direction(width: float, wx: float, wy: float, strength: Vector, moments: Vector) -> None:
    """moments (C, 2 bands - 1) += width strength e^{imθ}."""
    for colour in range(strength.size):
        real, imaginary = width * strength[colour], 0.0
        moments[colour, 0] += real
        for m in range(1, moments.shape[1] // 2 + 1):
            real, imaginary = real * wx - imaginary * wy, real * wy + imaginary * wx
            moments[colour, 2 * m - 1] += real
            moments[colour, 2 * m] += imaginary
