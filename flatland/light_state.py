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
    """Three buffers, stepped together; the light is kept near 1 by a power of two, `scale`.

    skip: cells along the first axis that light cannot have reached are left alone.
    """

    def __init__(self, layout: Layout, scale: float, skip: bool = True) -> None:
        self.layout, self.scale, self.skip = layout, scale, skip
        self.source, self.target, self.total = (layout.allocate() for _ in range(3))

    def reset(self) -> None:
        for buffer in (self.source, self.target, self.total):
            buffer[:] = 0

    def start(
        self,
        newest: NDArray[np.floating],
        passed: NDArray[np.floating] | None,
        components: list[int],
    ) -> None:
        """Begin with light (size, *shape) in units of `scale`; `passed` has moved on already.

        components: those whose sums over cells the books need.
        """
        self.reset()
        self.layout.view(self.target)[...] = newest
        self.total[:] = self.target
        if passed is not None:
            self.layout.view(self.total)[...] += passed
        self.start_norm = norm(self.target)
        self.norm = self.start_norm
        self.component_sums = self.sums_of(self.target, components)
        self._lit = self._lit_planes() if self.skip else (0, self.layout.shape[0])

    def _lit_planes(self) -> tuple[int, int]:
        """First and last (excluded) cell along the first axis with newest light."""
        view = self.layout.view(self.target)
        lit = np.flatnonzero((view != 0).any(axis=(0, *range(2, view.ndim))))
        return (int(lit[0]), int(lit[-1]) + 1) if lit.size else (0, 0)

    def sums_of(self, buffer: Buffer, components: list[int]) -> NDArray[np.float64]:
        """Sums over cells of some components."""
        return np.asarray(self.layout.body(buffer)[components].sum(axis=1, dtype=float))

    @property
    def batch(self) -> int:
        """Steps that may run before the next look."""
        return BATCH if self.norm <= SUSPICIOUS_GROWTH * self.start_norm else 1

    def advance(self, count: int, sweep: Sweep) -> StepSums:
        """`count` more steps."""
        # A step goes one cell far.
        first, last = self._lit
        lit = (max(0, first - count), min(self.layout.shape[0], last + count))
        if first < last:
            self._lit = lit
        sums = sweep.steps(self.target, self.source, self.total, count, self._lit)
        if count % 2:
            self.source, self.target = self.target, self.source
        self.component_sums = sums.components[-1]
        self.norm = float(np.sqrt(sums.squares[-1]))
        return sums

    @property
    def tame(self) -> bool:
        """Whether the light has not grown wild."""
        return self.norm <= LARGEST_GROWTH * self.start_norm

    def require_tame(self, iteration: int) -> None:
        """Raise InstabilityError if the light has grown wild; the state stays as it is."""
        if not self.tame:
            growth = self.norm / self.start_norm
            message = (
                f"the light has grown by a factor {growth:.1e} at iteration {iteration}: the "
                "scheme is unstable; the last state is kept"
            )
            raise InstabilityError(message)

    def values(self, buffer: Buffer) -> NDArray[np.floating]:
        """The cells (size, *shape) of one of the buffers, scaled as the light really is."""
        return self.layout.view(buffer) * self.layout.dtype.type(self.scale)


def light_scale(pattern: NDArray[np.float64]) -> float:
    """The power of two just below the largest coefficient of a pattern of light; 1 without light.

    It changes no digit; fluxes of 1e30 W then do not overflow float32.
    """
    largest = float(np.abs(pattern).max(initial=0.0))
    return float(2.0 ** np.floor(np.log2(largest))) if largest > 0 else 1.0
