"""How far light has got on each level of an octree, as far as that is asked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.level import Level
from flatland.octree.arrival import NEVER, Arrival, offsets_used

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Goal:
    """Where all levels are to be: at an iteration, or at the converged field."""

    iteration: int = 0
    tolerance: float | None = None
    method: str = "auto"


class Reach:
    """Where one level's light was at an iteration, and where it gets from there.

    patience: light counts where as many steps were done since as it took, times this.
    """

    def __init__(self, level: Level, iteration: int, patience: float) -> None:
        self._level, self._iteration, self._patience = level, iteration, patience
        self._lit = level.lit_cells()
        self._free = level.free_first_step and level.iteration == 0

    @cached_property
    def _arrival(self) -> Arrival:
        stencil, tau = self._level.stencil, self._level.occlusion.transmittance
        used = offsets_used(stencil)
        open_share = None if tau is None else tau[used]
        return Arrival(self._lit, stencil.offsets[used], open_share, self._free)

    def reached(self, goal: Goal) -> Mask:
        """Elements that light has got to."""
        return self._arrival.reached(self._steps(goal))

    def complete(self, goal: Goal) -> bool:
        """Whether light has got everywhere."""
        return self._arrival.complete(self._steps(goal))

    def _steps(self, goal: Goal) -> int:
        """Steps within which light must have come."""
        if goal.tolerance is not None:
            return int(NEVER) - 1
        return int((goal.iteration - self._iteration) / self._patience)
