"""Damped Jacobi sweeps of 1 − A on a grid, by the kernel of A."""

from __future__ import annotations

from flatland.kernels import Sweep
from flatland.kernels.reports import Buffer
from flatland.kernels.threads import address

#: Weight of a smoothing sweep; measured best of 0.5 … 1.0 for LPV and DOM (1.0 does not smooth the
#: checkerboard, which an axial scheme maps to its negative).
DAMPING = 0.8


class SweptLevel:
    """One grid of a hierarchy: (1 − A) answer = right, in the precision of the sweep's layout."""

    def __init__(self, sweep: Sweep) -> None:
        self.sweep, self.layout = sweep, sweep.layout
        self.right, self.answer, self.scratch = (self.layout.allocate() for _ in range(3))
        self._at = {name: address(getattr(self, name)) for name in ("right", "answer", "scratch")}
        self._by_address = not sweep.by_matrices and sweep.reflection is None

    @property
    def bytes(self) -> int:
        """Memory of the fields."""
        return 3 * self.layout.size * self.layout.dtype.itemsize

    def smooth(self, count: int) -> None:
        """Sweeps on the answer."""
        for _ in range(count):
            self._combine((1 - DAMPING, DAMPING, DAMPING), "answer", "right", "scratch")
            self.answer, self.scratch = self.scratch, self.answer
            self._at["answer"], self._at["scratch"] = self._at["scratch"], self._at["answer"]

    def first_smooth(self) -> None:
        """Two sweeps from zero, which is one: x = (2ω − ω²) b + ω² A b."""
        factors = (2 * DAMPING - DAMPING**2, 0.0, DAMPING**2)
        self._combine(factors, "right", "right", "answer")

    def residual(self) -> Buffer:
        """b − x + A x, in scratch."""
        self._combine((-1.0, 1.0, 1.0), "answer", "right", "scratch")
        return self.scratch

    def _combine(
        self, factors: tuple[float, float, float], source: str, rest: str, target: str
    ) -> None:
        if self._by_address:
            at = self._at
            self.sweep.combine_at(factors, at[source], at[rest], at[target])
        else:
            self.sweep.combine(
                *factors, getattr(self, source), getattr(self, rest), getattr(self, target)
            )
