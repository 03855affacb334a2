"""Light carried along ordinates: from every side that shines, through the cells, to the next."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, shared
from propagators.beam.strips import Surfaces, View, along, element_at, make_view, turn
from propagators.beam.tracing import trace
from propagators.beam.walking import find_beams, make_beams, set_amount

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


class Tally(NamedTuple):
    """What beams leave behind, without what other threads found.

    dx, dy: ends of runs, see `tracing`; without lanes cells are not looked at. arrived: (E, 2, C)
    flux on each side of each element. emitted, left: (C,).
    """

    dx: Vector
    dy: Vector
    arrived: Vector
    emitted: Vector
    left: Vector


@shared
def carry(
    directions: Vector,
    harmonics: Vector,
    weight: float,
    surfaces: Surfaces,
    radiance: Vector,
    order: Counts,
    tally: Tally,
) -> None:
    """Adds the ordinates `directions` (K, 2) and their opposites to the tally.

    harmonics: (2, K, size), of the ordinates and of their opposites, times the weight [rad].
    radiance: (E, 2, C) of left and right side. order: see `make_view`.
    """
    view, beams = make_view(surfaces, order), make_beams(surfaces)
    amount = np.empty(max(tally.dx.shape[2] - 1, 0))
    for k in range(directions.shape[0]):
        wx, wy = directions[k, 0], directions[k, 1]
        turn(wx, wy, surfaces, view)
        for n in range(find_beams(surfaces, view, beams)):
            way, (sender, receiver) = beams.ways[n], (beams.pieces[n, 0], beams.pieces[n, 1])
            low, high = beams.across[n, 0], beams.across[n, 1]
            sent = radiance[beams.elements[n], beams.sides[n, 0]]
            _book(sent, receiver, beams.sides[n, 1], low, high, weight, surfaces, view, tally)
            if amount.size > 0:
                set_amount(sent, harmonics[way, k], amount)
                sign = 1.0 - 2.0 * way
                _trace(sign, wx, wy, sender, receiver, low, high, amount, surfaces, view, tally)


@inlined
def _book(
    sent: Vector,
    receiver: int,
    facing: int,
    p0: float,
    p1: float,
    weight: float,
    surfaces: Surfaces,
    view: View,
    tally: Tally,
) -> None:
    """Enter what one element sends, and where it arrives."""
    for colour in range(sent.size):
        tally.emitted[colour] += sent[colour] * (p1 - p0) * weight
    if receiver == surfaces.pieces.shape[0]:
        for colour in range(sent.size):
            tally.left[colour] += sent[colour] * (p1 - p0) * weight
        return
    low = p0
    while low < p1:
        e, high = element_at(receiver, low, surfaces, view)
        high = min(high, p1)
        for colour in range(sent.size):
            tally.arrived[e, facing, colour] += sent[colour] * (high - low) * weight
        low = high


@inlined
def _trace(
    sign: float,
    wx: float,
    wy: float,
    sender: int,
    receiver: int,
    p0: float,
    p1: float,
    amount: Vector,
    surfaces: Surfaces,
    view: View,
    tally: Tally,
) -> None:
    """Send one element's beam through the cells.

    sign: -1 along the opposite of the ordinate, for which p and t change their signs.
    """
    near0, near1 = sign * along(sender, p0, view), sign * along(sender, p1, view)
    far0 = far1 = math.inf
    # Without a receiver nothing stops on a grid line; what starts on one is passed over anyway.
    stops = surfaces.lines[sender]
    if receiver < surfaces.pieces.shape[0]:
        far0, far1 = sign * along(receiver, p0, view), sign * along(receiver, p1, view)
        stops = surfaces.lines[receiver]
    if sign < 0.0:
        p0, p1 = -p1, -p0
        near0, near1, far0, far1 = near1, near0, far1, far0
    trace(
        sign * wx, sign * wy, p0, p1, near0, near1, far0, far1, surfaces.lines[sender], stops,
        amount, tally.dx, tally.dy,
    )  # fmt: skip
