"""What the kernels of a step report, and where."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.reports import StepSums


class Columns:
    """Where the kernels of a step leave their sums, in a row of numbers.

    The step's components and squares; the flux that left; that was sent; then what a reflection
    changed of components and squares, and the flux that came back.
    """

    def __init__(self, components: int) -> None:
        self._components = components
        self.width = 2 * components + 5
        #: First columns of what each kernel reports.
        self.first = {
            "step": 0,
            "left": components + 1,
            "sent": components + 2,
            "returned": components + 3,
        }

    def read(self, rows: NDArray[np.float64], clamped: bool, returned: bool) -> StepSums:
        """Rows (steps, width) as a report."""
        count = self._components
        own, back = rows[:, : count + 1], rows[:, count + 3 : -1]
        both = own + back
        return StepSums(
            both[:, :-1],
            both[:, -1],
            rows[:, count + 1],
            rows[:, count + 2] if clamped else None,
            rows[:, -1] if returned else None,
        )
