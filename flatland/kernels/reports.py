"""What a sweep tells about the steps it did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Numbers of a field in float32 or float64, border included.
Buffer = NDArray[Any]


@dataclass(frozen=True)
class StepSums:
    """What steps report, per step: arrays (steps, …), all in float64.

    components: sum over cells of each component asked for. squares: sum of all squares of all
    coefficients. left: flux (in units of coefficient 0) that left the grid.
    """

    components: NDArray[np.float64]
    squares: NDArray[np.float64]
    left: NDArray[np.float64]
    #: Flux that all cells sent, where it is not Σ flux_gain · components (clamped steps only).
    sent: NDArray[np.float64] | None = None
    #: Flux that walls sent back, already part of `components`; None where nothing reflects.
    reflected: NDArray[np.float64] | None = None

    @classmethod
    def joined(cls, reports: Sequence[StepSums]) -> StepSums:
        """The reports of steps one after another as one."""
        parts: dict[str, NDArray[np.float64] | None] = {}
        for entry in fields(cls):
            values = [getattr(report, entry.name) for report in reports]
            parts[entry.name] = None if values[0] is None else np.concatenate(values)
        return cls(**parts)  # type: ignore[arg-type]
