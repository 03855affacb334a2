"""The fields of a run: source, target and accumulated, once per independent spectrum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.errors import InstabilityError
from flatland.kernels import Layout, Sweep
from flatland.kernels.reports import Buffer, StepSums
from flatland.solvers.vectors import norm

#: A run is stopped when its light, in the L2 norm, has grown by this much: far above anything
#: physical, and so far below overflow that the last state is still a state.
LARGEST_GROWTH = 1e12
#: Beyond this growth every single step is looked at.
SUSPICIOUS_GROWTH = 1e3
#: Steps between two looks at the books.
BATCH = 16


class LightState:
    """Three buffers, stepped together; the light is kept near 1 by a power of two.

    pattern: (size, *shape), the light to start from.
    """

    def __init__(self, layout: Layout, sweep: Sweep, pattern: NDArray[np.float64]) -> None:
        self.layout, self.sweep = layout, sweep
        self.pattern = pattern
        largest = float(np.abs(pattern).max(initial=0.0))
        # A power of two changes no digit; fluxes of 1e30 W then do not overflow float32.
        self.scale = 2.0 ** np.floor(np.log2(largest)) if largest > 0 else 1.0
        self.source, self.target, self.total = (layout.allocate() for _ in range(3))

    def reset(self) -> None:
        for buffer in (self.source, self.target, self.total):
            buffer[:] = 0

    def inject(self) -> None:
        self.reset()
        self.layout.view(self.target)[...] = self.pattern / self.scale
        self.total[:] = self.target
        self.start_norm = norm(self.target)
        self.norm = self.start_norm
        self.component_sums = self.sums_of(self.target)

    def sums_of(self, buffer: Buffer) -> NDArray[np.float64]:
        """Sums over cells of the components that the books need."""
        wanted = list(self.sweep.recipe.sums)
        return np.asarray(self.layout.body(buffer)[wanted].sum(axis=1, dtype=float))

    @property
    def batch(self) -> int:
        """Steps that may run before the next look."""
        return BATCH if self.norm <= SUSPICIOUS_GROWTH * self.start_norm else 1

    def advance(self, count: int, sweep: Sweep | None = None) -> StepSums:
        """`count` more steps, by another sweep than the usual one if given."""
        sums = (sweep or self.sweep).steps(self.target, self.source, self.total, count)
        if count % 2:
            self.source, self.target = self.target, self.source
        self.component_sums = sums.components[-1]
        self.norm = float(np.sqrt(sums.squares[-1]))
        return sums

    def require_tame(self, iteration: int) -> None:
        """Raise InstabilityError if the light has grown wild; the state stays as it is."""
        if not self.norm <= LARGEST_GROWTH * self.start_norm:
            growth = self.norm / self.start_norm
            message = (
                f"the light has grown by a factor {growth:.1e} at iteration {iteration}: the "
                "scheme is unstable; the last state is kept"
            )
            raise InstabilityError(message)

    def values(self, buffer: Buffer) -> NDArray[np.floating]:
        """The cells (size, *shape) of one of the buffers, scaled as the light really is."""
        return self.layout.view(buffer) * self.layout.dtype.type(self.scale)
