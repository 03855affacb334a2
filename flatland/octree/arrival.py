"""When light first gets to each cell: known without any light, from links alone."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels.orbits import significant
from flatland.stencil import Stencil

Mask = NDArray[np.bool_]

#: Of cells that no light gets to.
NEVER = np.iinfo(np.int32).max


def offsets_used(stencil: Stencil) -> NDArray[np.bool_]:
    """Which of a scheme's offsets (K,) it sends any light along."""
    return np.asarray(significant(stencil.transfer).any(axis=(1, 2)))


class Arrival:
    """Steps until each cell first receives light, found as far as they are asked for.

    lit: (*shape), where light is at the start. It goes along offsets (K, dimension) where the link
    is not shut (transmittance: (K, *shape), τ > 0); free_first_step: the first step passes shut
    links. A cell in which several contributions happen to cancel counts as lit,
    as does one whose light is too faint for a floating-point number; a value that is exactly zero
    is the only way in which this differs from looking at the light itself.
    """

    def __init__(
        self,
        lit: Mask,
        offsets: NDArray[np.int64],
        transmittance: NDArray[np.float64] | None = None,
        free_first_step: bool = False,
    ) -> None:
        shape = lit.shape
        padded = tuple(n + 2 for n in shape)
        self._inner = tuple(slice(1, -1) for _ in shape)
        # The border counts as reached, so that nothing goes there.
        self._times = np.full(padded, -1, np.int32)
        self._times[self._inner] = np.where(lit, 0, NEVER)
        strides = [math.prod(padded[axis + 1 :]) for axis in range(len(shape))]
        self._shifts = offsets @ np.array(strides)
        self._links = np.zeros((0, 0), bool)
        if transmittance is not None:
            wide = np.zeros((self._shifts.size, *padded), bool)
            wide[(slice(None), *self._inner)] = transmittance > 0
            self._links = wide.reshape(self._shifts.size, -1)
        self._free = free_first_step
        seeds = np.flatnonzero(self._times == 0)
        self._queue = np.empty(lit.size, np.int64)
        self._seeds, self._dimension = seeds.size, len(shape)
        self._queue[: seeds.size] = seeds
        #: Cells of the queue that were handled, and that were reached.
        self._done, self._count = 0, seeds.size

    def steps(self, until: int = NEVER) -> NDArray[np.int32]:
        """Steps of arrival, (*shape); more than `until` of them may be given as NEVER."""
        self._find(until)
        return self._times[self._inner]

    def reached(self, after: int) -> Mask:
        """Where light has been after so many steps, (*shape)."""
        return np.asarray(self.steps(after) <= after)

    def complete(self, after: int) -> bool:
        """Whether light has been everywhere after so many steps."""
        if self._seeds * (2 * after + 1) ** self._dimension < self._queue.size:
            return False  # not even in the open: nothing to look for
        self._find(after)
        everywhere = self._count == self._queue.size
        return bool(everywhere and self._times.ravel()[self._queue[-1]] <= after)

    def _find(self, until: int) -> None:
        self._done, self._count = _spread(
            self._times.ravel(), self._queue, self._done, self._count, self._shifts, self._links,
            self._free, until,
        )  # fmt: skip


@njit(cache=True)
def _spread(times, queue, done, count, shifts, links, free, until):  # type: ignore[no-untyped-def]
    """Breadth-first: neighbours of all reached cells whose time is below `until`."""
    while done < count and times[queue[done]] < until:
        cell = queue[done]
        done += 1
        blocked = links.size > 0 and not (free and times[cell] == 0)
        for d in range(shifts.size):
            if blocked and not links[d, cell]:
                continue
            place = cell + shifts[d]
            if times[place] == NEVER:
                times[place] = times[cell] + 1
                queue[count] = place
                count += 1
    return done, count
