"""One linear system: light, and the operator it goes through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatland.kernels import Sweep
from flatland.kernels.reports import Buffer
from flatland.memory import available_memory
from flatland.solvers.lighted import lighted_cells, reflection_in
from flatland.solvers.vectors import dot, norm
from flatland.solvers.watching import applied

#: Residual of the last answer, scaled, below which it is begun with; and the part of the free
#: memory that it may be kept in.
_WORTH_KNOWING = 0.1
_SHARE_OF_MEMORY = 0.05


class Problem:
    """(1 − A) x = b on padded float64 buffers; the border of zeros stays zero."""

    def __init__(self, sweep: Sweep, right: Buffer) -> None:
        #: Where light gets to; the rest of the answer is zero.
        self.lighted: NDArray[np.bool_] | None = None
        if sweep.reflection is not None:
            self.lighted = lighted_cells(sweep, right)
        self.sweep = in_double(sweep, self.lighted)
        self.right = self.sweep.layout.allocate()
        self.sweep.layout.view(self.right)[...] = sweep.layout.view(right)
        #: The light whose answer is wanted; `right` is what is left of it to be solved for.
        self.light = self.right
        self.start: Buffer | None = None
        self.applications = 0
        self.iterations = 0

    def start_from_last(self) -> None:
        """Begin with the last answer of this operator, if it holds most of this one."""
        if self.sweep.known is None:
            return
        light, answer = self.sweep.known
        start = dot(light, self.light) / dot(light, light) * answer
        rest = self.sweep.layout.allocate()
        self.apply(start, rest)
        np.subtract(self.light, rest, out=rest)
        if norm(rest) < _WORTH_KNOWING * norm(self.light):
            self.start, self.right = start, rest

    def keep(self, values: Buffer) -> None:
        """Remember an answer for other lights."""
        small = 2 * values.nbytes < _SHARE_OF_MEMORY * available_memory()
        self.sweep.known = (self.light, values) if small and self.light.any() else None

    def apply(self, values: Buffer, result: Buffer) -> None:
        """(1 − A) x."""
        self.count(1)
        self.sweep.combine(1.0, 0.0, -1.0, values, values, result)

    def count(self, applications: int) -> None:
        self.applications += applications
        applied(applications)

    def residual(self, answer: Buffer) -> float:
        scale = norm(self.light)
        defect = self.sweep.layout.allocate()
        self.sweep.combine(-1.0, 1.0, 1.0, answer, self.light, defect)
        return norm(defect) / scale if scale else 0.0


def in_double(sweep: Sweep, lighted: NDArray[np.bool_] | None) -> Sweep:
    """The same sweep in float64, with what reflects in some cells only.

    Kept with the sweep, until other cells are asked for.
    """
    if sweep.reflection is None and sweep.layout.dtype == np.float64:
        return sweep
    key = None if lighted is None else lighted.tobytes()
    if sweep.double is None or sweep.double[0] != key:
        layout = replace(sweep.layout, dtype=np.dtype(np.float64))
        twin = Sweep(sweep.stencil, layout, sweep.open_share)
        if sweep.reflection is not None and lighted is not None:
            twin = twin.reflecting(reflection_in(sweep.reflection, lighted))
        sweep.double = key, twin
    return sweep.double[1]
