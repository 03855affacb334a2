"""Form factors between elements of walls, by crossed strings past everything in between.

What element j sends to element i per unit of radiance, X_ij, is length times form factor times
two: X_ij = 2 l_j F_ji = 2 l_i F_ij (reciprocity). It is the band 0 of `targets`, so that what
every element sends is found again on walls and on the border (closure), to rounding.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import front_parts, make_scratch
from propagators.analytic.compiling import share_work, shared
from propagators.analytic.shafts import keep_between
from propagators.analytic.targets import receive

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


def exchange_matrix(
    panels: Vector,
    first: Counts,
    elements: Vector,
    walls: Vector,
    visible: NDArray[np.bool_] | None = None,
) -> Vector:
    """Symmetric X (K, K), in cells, of elements (K, 4) that light and receive on their left.

    panels: (N, 4) straight pieces of wall; the elements first[n] … first[n + 1] - 1 cut panel n.
    visible: (N, N), which panels see one another, if that is known. Each pair is computed once.
    """
    parts, counts = front_parts(panels, walls)
    if visible is None:
        visible = np.ones((len(panels), len(panels)), bool)
    result = np.zeros((len(elements), len(elements)))
    given = panels, first, elements, visible, parts, counts
    share_work(_exchange, len(elements), *given, result)
    return result


@shared
def _exchange(
    party: int,
    parties: int,
    panels: Vector,
    first: Counts,
    elements: Vector,
    visible: NDArray[np.bool_],
    parts: Vector,
    counts: Counts,
    result: Vector,
) -> None:
    work, moments = make_scratch(parts.shape[1]), np.empty(1)
    wide, narrow = np.empty(parts.shape[1:]), np.empty(parts.shape[1:])
    for b in range(panels.shape[0]):
        for a in range(b):
            if not visible[a, b]:
                continue
            between = keep_between(panels[a], panels[b], parts[b], counts[b], wide)
            if between < 0:
                continue
            for i in range(first[a] + party, first[a + 1], parties):
                left = keep_between(elements[i], panels[b], wide, between, narrow)
                for j in range(first[b], first[b + 1] if left >= 0 else first[b]):
                    if receive(elements[i], elements[j], narrow, left, work, moments):
                        result[i, j] = result[j, i] = moments[0]
