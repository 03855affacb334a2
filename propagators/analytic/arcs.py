"""The visible arcs themselves: the angular distribution of light at a point, not band-limited."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import make_scratch
from propagators.analytic.compiling import shared
from propagators.analytic.views import view

Vector = NDArray[np.float64]


class Arc(NamedTuple):
    """Light that travels at angles from start to stop [rad], counter-clockwise, at one point.

    start lies in (-π, π], stop at most π beyond it. radiance: [W m⁻¹ rad⁻¹], a number, or
    (colours,) in coloured scenes. emitter: its place in scene.sources("lamp"); of light that a
    wall sends back, -1 minus the wall's place in scene.segments().
    """

    start: float
    stop: float
    radiance: float | Vector
    emitter: int


@shared
def visible_arcs(x: float, y: float, emitters: Vector, walls: Vector) -> Vector:
    """Rows (start, stop, emitter) of the arcs of emitters (E, 4) that reach (x, y) past walls."""
    work = make_scratch(walls.shape[0])
    rows = np.empty((emitters.shape[0] * (walls.shape[0] + 1), 3))
    count = 0
    for e in range(emitters.shape[0]):
        # Light travels from the emitter to the point: half a turn from the direction it is seen in.
        travel = math.atan2(emitters[e, 2] - emitters[e, 0], emitters[e, 1] - emitters[e, 3])
        for k in range(view(x, y, emitters[e], walls, work)):
            low, high = work.arcs[2 * k + 1], work.arcs[2 * k]
            start = travel + math.atan2(-work.edges[low, 0], work.edges[low, 1])
            stop = travel + math.atan2(-work.edges[high, 0], work.edges[high, 1])
            turn = 2 * math.pi * math.ceil((start - math.pi) / (2 * math.pi))
            rows[count, 0], rows[count, 1], rows[count, 2] = start - turn, stop - turn, e
            count += 1
    return rows[:count]
