"""Light that one emitter sends through one side of a target segment, in closed form."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import (
    TOUCH,
    Scratch,
    clip,
    collect_blockers,
    front_parts,
    make_scratch,
)
from propagators.analytic.compiling import inner, share_work, shared
from propagators.analytic.strings import add_beam, turn_moments
from propagators.analytic.visibility import collect_arcs, collect_breaks

Vector = NDArray[np.float64]


@inner
def receive(
    target: Vector,
    emitter: Vector,
    parts: Vector,
    count: int,
    work: Scratch,
    moments: Vector,
) -> bool:
    """moments (2 bands - 1,) = ∫dA ∫_{n·ω>0} (n·ω) e^{imθ} dω for radiance 1; False if dark.

    target: (4,) start and stop, receives light from its left, so that n is on its right.
    emitter: (4,), lights its left. parts: what may block it (`front_parts`).
    """
    x, y = target[0], target[1]
    tx, ty = target[2] - x, target[3] - y
    length = math.sqrt(tx * tx + ty * ty)
    nx, ny = ty / length, -tx / length
    ax, ay, bx, by = emitter[0], emitter[1], emitter[2], emitter[3]
    da, db = -((ax - x) * nx + (ay - y) * ny), -((bx - x) * nx + (by - y) * ny)
    if max(da, db) <= TOUCH:
        return False
    ex, ey = bx - ax, by - ay
    size = math.sqrt(ex * ex + ey * ey)
    f0 = (ex * (y - ay) - ey * (x - ax)) / size
    f1 = (ex * (target[3] - ay) - ey * (target[2] - ax)) / size
    if max(f0, f1) <= TOUCH:
        return False
    t0, _, t1, _ = clip(0.0, 0.0, length, 0.0, f0, f1)
    ta, tb = (ay - y) * nx - (ax - x) * ny, (by - y) * nx - (bx - x) * ny
    edges = work.edges
    # The target is to the left of a -> b, so that b is seen at the smaller key.
    edges[1, 0], edges[1, 1], edges[0, 0], edges[0, 1] = clip(ta, da, tb, db, da, db)
    blockers = collect_blockers(x, y, nx, ny, t0, t1, parts, count, work)
    if blockers < 0:
        return False
    moments.fill(0.0)
    if blockers == 0:
        add_beam(moments, t0, t1, edges[0, 0], edges[0, 1], edges[1, 0], edges[1, 1])
    else:
        _sweep(t0, t1, blockers, work, moments)
    turn_moments(moments, nx, ny)
    return True


@inner
def _sweep(t0: float, t1: float, blockers: int, work: Scratch, moments: Vector) -> None:
    """Adds the beams seen from [t0, t1], each over the longest stretch with the same edges."""
    breaks = work.breaks
    count = collect_breaks(t0, t1, blockers, work, breaks)
    if count > breaks.size:
        breaks = np.empty(count)
        count = collect_breaks(t0, t1, blockers, work, breaks)
    found = breaks[:count]
    _sort(found)
    for k in range(blockers):
        work.order[k] = k
    start, position, seen = t0, t0, 0
    for k in range(count + 1):
        stop = found[k] if k < count else t1
        # A narrower stretch than rounding can place is joined to the next one.
        if stop - position <= 1e-13 * (1.0 + t1) and k < count:
            continue
        arcs = collect_arcs(0.5 * (position + stop), blockers, work)
        if position > t0 and not _same(arcs, seen, work):
            _add_seen(start, position, seen, work, moments)
            start = position
        for i in range(2 * arcs):
            work.previous[i] = work.arcs[i]
        seen, position = arcs, stop
    _add_seen(start, t1, seen, work, moments)


@inner
def _sort(values: Vector) -> None:
    """Insertion sort in place: the lists are short, and a library sort takes 2 s to compile."""
    for k in range(1, values.size):
        moved, place = values[k], k
        while place > 0 and values[place - 1] > moved:
            values[place] = values[place - 1]
            place -= 1
        values[place] = moved


@inner
def _same(arcs: int, seen: int, work: Scratch) -> bool:
    different = arcs != seen
    for k in range(2 * min(arcs, seen)):
        different |= work.arcs[k] != work.previous[k]
    return not different


@inner
def _add_seen(t0: float, t1: float, seen: int, work: Scratch, moments: Vector) -> None:
    for k in range(seen):
        low, high = work.edges[work.previous[2 * k]], work.edges[work.previous[2 * k + 1]]
        add_beam(moments, t0, t1, low[0], low[1], high[0], high[1])


def collect_light(
    targets: Vector, emitters: Vector, radiance: Vector, walls: Vector, bands: int
) -> Vector:
    """Moments (G, C, 2 bands - 1) of the light that arrives on groups of targets.

    targets: (G, P, 4) segments in cells, lit from their left; a group adds its P targets up.
    emitters: (E, 4). radiance: (E, C), flux per angle and cell length. walls: (S, 4), block.
    """
    parts, counts = front_parts(emitters, walls)
    result = np.zeros((len(targets), radiance.shape[1], 2 * bands - 1))
    share_work(_collect, len(targets), targets, emitters, radiance, parts, counts, result)
    return result


@shared
def _collect(
    party: int,
    parties: int,
    targets: Vector,
    emitters: Vector,
    radiance: Vector,
    parts: Vector,
    counts: NDArray[np.int64],
    result: Vector,
) -> None:
    work = make_scratch(parts.shape[1])
    moments = np.empty(result.shape[2])
    for g in range(party, targets.shape[0], parties):
        for p in range(targets.shape[1]):
            for e in range(emitters.shape[0]):
                if receive(targets[g, p], emitters[e], parts[e], counts[e], work, moments):
                    for colour in range(radiance.shape[1]):
                        for k in range(moments.size):
                            result[g, colour, k] += radiance[e, colour] * moments[k]
