"""When light first gets to each cell: known without any light, from links alone."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels.assembly import significant
from flatland.stencil import Stencil

Steps = NDArray[np.int32]

#: Of cells that no light ever gets to.
NEVER = np.iinfo(np.int32).max


def arrival_steps(
    lit: NDArray[np.bool_],
    stencil: Stencil,
    transmittance: NDArray[np.float64] | None = None,
    free_first_step: bool = False,
) -> Steps:
    """Steps until each cell first receives light, (*shape); 0 where it is lit, NEVER if never.

    Light goes along an offset if the scheme sends any there and the link is not shut (τ > 0). A
    cell in which several contributions happen to cancel counts as lit, as does one whose light
    is too faint for a floating-point number; a value that is exactly zero is the only way in
    which this differs from looking at the light itself.
    """
    shape = lit.shape
    offsets = stencil.offsets[significant(stencil.transfer).any(axis=(1, 2))]
    padded = tuple(n + 2 for n in shape)
    inner = tuple(slice(1, -1) for _ in shape)
    # The border counts as reached, so that nothing goes there.
    times = np.full(padded, -1, np.int32)
    times[inner] = np.where(lit, 0, NEVER)
    strides = np.array([int(np.prod(padded[axis + 1 :])) for axis in range(len(shape))])
    links = np.zeros((0, 0), bool)
    if transmittance is not None:
        used = significant(stencil.transfer).any(axis=(1, 2))
        wide = np.zeros((len(offsets), *padded), bool)
        wide[(slice(None), *inner)] = transmittance[used] > 0
        links = wide.reshape(len(offsets), -1)
    flat = times.ravel()
    queue = np.empty(lit.size, np.int64)
    seeds = np.flatnonzero(flat == 0)
    queue[: seeds.size] = seeds
    _spread(flat, queue, seeds.size, offsets @ strides, links, free_first_step)
    return np.ascontiguousarray(times[inner])


@njit(cache=True)
def _spread(times, queue, count, shifts, links, free_first):  # type: ignore[no-untyped-def]
    """Breadth-first from the first `count` cells of the queue."""
    head = 0
    while head < count:
        cell = queue[head]
        head += 1
        blocked = links.size > 0 and not (free_first and times[cell] == 0)
        for d in range(shifts.size):
            if blocked and not links[d, cell]:
                continue
            place = cell + shifts[d]
            if times[place] == NEVER:
                times[place] = times[cell] + 1
                queue[count] = place
                count += 1
