"""What is left of beams after everything that cuts them, overlaps counted once."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Links = NDArray[np.int64]


def open_shares(links: Links, spans: Array, sides: NDArray[np.uint8]) -> tuple[Links, Array]:
    """The open share of every link that occurs, from records in any order.

    links: (M,) numbers of links. spans: (M, 2), parts of 0 … 1 that are covered. sides: (M,), how
    the centre ray is reached (see `tiles`). Returns the links (U,), each once, and shares (U,).
    A link is shut where its centre ray is reached in two ways: walls reach across the ray, or
    leave a wall that lies on it. Reached from one side only, the ray passes beside an end or a
    corner, which shuts nothing.
    """
    order = np.lexsort((spans[:, 0], links))
    found, shares = _merge(links[order], spans[order], sides[order])
    return found, shares


@njit(cache=True, error_model="numpy", nogil=True)
def _merge(links: Links, spans: Array, sides: NDArray[np.uint8]) -> tuple[Links, Array]:
    """One pass over records sorted by link, then by the lower end of their span."""
    found = np.empty_like(links)
    shares = np.empty(links.size)
    count = position = 0
    while position < links.size:
        link, covered, reached, ways = links[position], 0.0, 0.0, 0
        while position < links.size and links[position] == link:
            covered += max(spans[position, 1] - max(spans[position, 0], reached), 0.0)
            reached = max(reached, spans[position, 1])
            ways |= sides[position]
            position += 1
        found[count] = link
        # ways & (ways - 1) is not zero where more than one bit is set.
        shares[count] = 0.0 if ways & (ways - 1) else max(0.0, 1.0 - covered)
        count += 1
    return found[:count], shares[:count]
