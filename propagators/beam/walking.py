"""The beams of one direction: from each element that shines, in its strip, to what stops it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner
from propagators.beam.strips import Surfaces, View, element_at, find_strips

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


class Beams(NamedTuple):
    """ways: (N,), 0 along ω, 1 along -ω. pieces: (N, 2), which sends and which receives, S for the
    outside. elements: (N,) that send. sides: (N, 2), of the sender and of the receiver. across:
    (N, 2), from which p to which.
    """

    ways: Counts
    pieces: Counts
    elements: Counts
    sides: Counts
    across: Vector


@inner
def make_beams(surfaces: Surfaces) -> Beams:
    """Room for the beams of one direction after the other."""
    pieces = surfaces.pieces.shape[0]
    # Both ways each strip begins a beam, and each element but the first of its piece.
    most = 2 * (4 * pieces + surfaces.elements[pieces])
    return Beams(
        np.empty(most, np.int64),
        np.empty((most, 2), np.int64),
        np.empty(most, np.int64),
        np.empty((most, 2), np.int64),
        np.empty((most, 2)),
    )


@inlined
def find_beams(surfaces: Surfaces, view: View, beams: Beams) -> int:
    """Writes down the beams of a view; their number."""
    count, outside = 0, surfaces.pieces.shape[0]
    for strip in range(find_strips(surfaces, view)):
        for way in range(2):
            sender, receiver = view.pairs[strip, way], view.pairs[strip, 1 - way]
            if not view.sends[way, sender]:
                continue
            side = view.ahead[sender] if way == 0 else 1 - view.ahead[sender]
            facing = outside
            if receiver != outside:
                facing = 1 - view.ahead[receiver] if way == 0 else view.ahead[receiver]
            low, stop = view.across[strip, 0], view.across[strip, 1]
            while low < stop:
                e, high = element_at(sender, low, surfaces, view)
                high = min(high, stop)
                beams.ways[count], beams.elements[count] = way, e
                beams.pieces[count, 0], beams.pieces[count, 1] = sender, receiver
                beams.sides[count, 0], beams.sides[count, 1] = side, facing
                beams.across[count, 0], beams.across[count, 1] = low, high
                count += 1
                low = high
    return count


@inlined
def set_amount(sent: Vector, harmonics: Vector, amount: Vector) -> None:
    """amount (C * size,) = radiance (C,) times harmonics (size,)."""
    for colour in range(sent.size):
        for k in range(harmonics.size):
            amount[colour * harmonics.size + k] = sent[colour] * harmonics[k]
