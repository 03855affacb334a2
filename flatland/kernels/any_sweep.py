"""What the engine needs of a sweep, wherever its fields are."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.box import Box
from flatland.kernels.layout import Layout
from flatland.kernels.reflection import Reflection
from flatland.kernels.reports import Buffer, StepSums
from flatland.stencil import Stencil


class AnySweep(Protocol):
    """One stencil on one layout, see `Sweep`; buffers are in this machine's memory."""

    stencil: Stencil
    layout: Layout
    open_share: NDArray[np.float64] | None
    reflection: Reflection | None

    def prepare(self, lit: Box) -> None: ...

    def steps(
        self, source: Buffer, target: Buffer, total: Buffer, count: int, lit: Box | None = None
    ) -> StepSums: ...

    def combine(
        self, own: float, other: float, arrived: float, source: Buffer, rest: Buffer, target: Buffer
    ) -> None: ...

    def reflecting(self, reflection: Reflection | None) -> AnySweep: ...

    def linear(self) -> AnySweep: ...
