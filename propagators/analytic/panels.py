"""Light of panels through targets: straight pieces of wall with one radiance per element.

Where nothing stands between a target and a panel, the strings of neighbouring elements meet in
their common end, so that each end V_k needs one pair of strings, times the step of radiance
there: Σ_k (L_{k-1} - L_k) (S(t1, V_k) - S(t0, V_k)), with L = 0 beyond the panel (see `strings`).
The rest goes element by element through `targets.receive`. The error is rounding of the longest
string, 1e-14 of the radiance a cell or so.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.threads import run_shared
from propagators.analytic.blockers import clip, front_parts, make_scratch
from propagators.analytic.compiling import inner, parties_for, shared
from propagators.analytic.shafts import distance_to, keep_between
from propagators.analytic.strings import add_string, turn_moments
from propagators.analytic.targets import receive
from propagators.analytic.tiles import bounds, keep_for_box, tiles_of
from propagators.watching import Progress

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Reports on the way, at most.
_REPORTS = 50


def collect_panel_light(
    targets: Vector,
    panels: Vector,
    first: Counts,
    elements: Vector,
    radiance: Vector,
    walls: Vector,
    bands: int,
    report: Progress,
) -> Vector:
    """Moments (G, C, 2 bands - 1) of the light of panels on groups of targets (G, P, 4).

    panels, first, elements: as in `exchange_matrix`. radiance: (K, C), flux per angle and cell
    length of each element. report: gets the share done. The same as `collect_light` with the
    elements as emitters, sooner.
    """
    parts, counts = front_parts(panels, walls)
    result = np.zeros((len(targets), radiance.shape[1], 2 * bands - 1))
    order, starts = tiles_of(targets)
    lights = panels, first, elements, radiance
    parties = parties_for(len(targets))
    together = max(parties, -(-len(starts) // _REPORTS))
    for begin in range(0, len(starts) - 1, together):
        tiles = starts[begin : begin + together + 1]

        def collect(party: int, running: int, tiles: Counts = tiles) -> None:
            _collect(party, running, order, tiles, targets, *lights, parts, counts, result)

        run_shared(collect, min(parties, len(tiles) - 1))
        report(min(1.0, (begin + together) / (len(starts) - 1)))
    return result


@shared
def _collect(
    party: int,
    parties: int,
    order: Counts,
    tiles: Counts,
    targets: Vector,
    panels: Vector,
    first: Counts,
    elements: Vector,
    radiance: Vector,
    parts: Vector,
    counts: Counts,
    result: Vector,
) -> None:
    work, kept = make_scratch(parts.shape[1]), np.empty(parts.shape[1:])
    moments, local = np.empty(result.shape[2]), np.empty(result.shape[1:])
    near, numbers = np.empty(parts.shape), np.empty(panels.shape[0], np.int64)
    box, strings = np.empty(4), np.empty((2, 4))
    for tile in range(party, tiles.size - 1, parties):
        groups = order[tiles[tile] : tiles[tile + 1]]
        bounds(targets, groups, box)
        for n in range(panels.shape[0]):
            numbers[n] = keep_for_box(box, panels[n], parts[n], counts[n], strings, near[n])
        for g in groups:
            for p in range(targets.shape[1]):
                target = targets[g, p]
                local.fill(0.0)
                for n in range(panels.shape[0]):
                    if numbers[n] < 0:
                        continue
                    left = keep_between(target, panels[n], near[n], numbers[n], kept)
                    low, high = first[n], first[n + 1]
                    if left == 0:
                        _add_open(target, panels[n], elements, low, high, radiance, moments, local)
                    for k in range(low, high if left > 0 else low):
                        if receive(target, elements[k], kept, left, work, moments):
                            _add(radiance[k], moments, result[g])
                _turn_and_add(target, local, result[g])


@inner
def _add(radiance: Vector, moments: Vector, result: Vector) -> None:
    for colour in range(radiance.size):
        for m in range(moments.size):
            result[colour, m] += radiance[colour] * moments[m]


@inner
def _turn_and_add(target: Vector, local: Vector, result: Vector) -> None:
    """result += local moments (C, 2 bands - 1), which count angles from the target's normal."""
    tx, ty = target[2] - target[0], target[3] - target[1]
    length = math.sqrt(tx * tx + ty * ty)
    for colour in range(local.shape[0]):
        turn_moments(local[colour], ty / length, -tx / length)
        for m in range(local.shape[1]):
            result[colour, m] += local[colour, m]


@inner
def _add_open(
    target: Vector,
    panel: Vector,
    elements: Vector,
    low: int,
    high: int,
    radiance: Vector,
    moments: Vector,
    local: Vector,
) -> None:
    """local (C, 2 bands - 1) += light of the elements low … high - 1, none of it stopped."""
    x, y = target[0], target[1]
    tx, ty = target[2] - x, target[3] - y
    length = math.sqrt(tx * tx + ty * ty)
    tx, ty = tx / length, ty / length
    ahead = distance_to(panel, x, y), distance_to(panel, target[2], target[3])
    t0, _, t1, _ = clip(0.0, 0.0, length, 0.0, ahead[0], ahead[1])
    start = distance_to(target, panel[0], panel[1])
    stop = distance_to(target, panel[2], panel[3])
    # Ends behind the target's line are moved to where the panel crosses it: no width is left.
    share = start / (start - stop) if start != stop else 0.0
    zero = (panel[0] + share * (panel[2] - panel[0]) - x) * tx
    zero += (panel[1] + share * (panel[3] - panel[1]) - y) * ty
    for k in range(low, high + 1):
        vx, vy = (elements[k, 0], elements[k, 1]) if k < high else (panel[2], panel[3])
        along, away = (vx - x) * tx + (vy - y) * ty, (vy - y) * tx - (vx - x) * ty
        if away < 0.0:
            along, away = zero, 0.0
        moments.fill(0.0)
        add_string(moments, 1.0, t1 - along, away)
        add_string(moments, -1.0, t0 - along, away)
        for colour in range(radiance.shape[1]):
            step = (radiance[k - 1, colour] if k > low else 0.0) - (
                radiance[k, colour] if k < high else 0.0
            )
            for m in range(moments.size):
                local[colour, m] += step * moments[m]
