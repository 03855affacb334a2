"""What elements of reflecting walls see of one another along a set of ordinates, as a matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import shared
from propagators.beam.strips import Surfaces, element_at, find_strips, make_view, turn

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


@shared
def collect_pairs(
    directions: Vector,
    surfaces: Surfaces,
    order: Counts,
    places: NDArray[np.int32],
    widths: Vector,
) -> int:
    """Pairs of sides that shine on one another along the ordinates `directions` (K, 2).

    places: (2, N), 2 e + side of sender and receiver. widths: (N,) of what they see of one another,
    across. Returns how many there are; those beyond N are not stored.
    """
    view = make_view(surfaces, order)
    count, outside = 0, surfaces.pieces.shape[0]
    for k in range(directions.shape[0]):
        turn(directions[k, 0], directions[k, 1], surfaces, view)
        for strip in range(find_strips(surfaces, view)):
            sender, receiver = view.pairs[strip, 0], view.pairs[strip, 1]
            if sender == outside or receiver == outside:
                continue
            if not (view.sends[0, sender] and view.sends[1, receiver]):
                continue
            low, stop = view.across[strip, 0], view.across[strip, 1]
            while low < stop:
                first, first_end = element_at(sender, low, surfaces, view)
                second, second_end = element_at(receiver, low, surfaces, view)
                high = min(stop, min(first_end, second_end))
                if count < widths.size:
                    places[0, count] = 2 * first + view.ahead[sender]
                    places[1, count] = 2 * second + 1 - view.ahead[receiver]
                    widths[count] = high - low
                count += 1
                low = high
    return count
