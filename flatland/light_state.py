"""The fields of a run: source, target and accumulated, once per independent spectrum."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flatland.errors import InstabilityError
from flatland.folding import Fold
from flatland.kernels import Layout
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.box import (
    Box,
    cell_count,
    cells_of,
    clear_outside,
    grown,
    hull,
    is_empty,
    nothing,
    trimmed,
    whole,
)
from flatland.kernels.reports import Buffer, StepSums
from flatland.patch import Patch

Values = NDArray[np.floating]

#: A run is stopped when its light, in the L2 norm, has grown by this much: far above anything
#: physical, and so far below overflow that the last state is still a state.
LARGEST_GROWTH = 1e12
#: Beyond this growth every single step is looked at.
SUSPICIOUS_GROWTH = 1e3
#: Looks at a grid that is lit from end to end before the next one whether it still is.
_SELDOM = 8
#: Steps between two looks at the books.
BATCH = 16


class LightState:
    """Three buffers, stepped together; the light is kept near 1 by a power of two, `scale`.

    part: the half, or less, of a whole grid that the buffers hold; None for all of it. skip: cells
    outside of a box round the newest light are left alone. drop: layers of that box whose
    coefficients are all below this part of the largest one at the start are taken away, and their
    flux counted.
    """

    def __init__(
        self,
        layout: Layout,
        scale: float,
        skip: bool = True,
        drop: float = 0.0,
        part: Fold | None = None,
    ) -> None:
        self.layout, self.scale, self.skip, self.drop = layout, scale, skip, drop
        self.part = part
        self.source, self.target, self.total = (layout.allocate() for _ in range(3))
        self._cells = math.prod(layout.shape)
        self._forget()

    def reset(self) -> None:
        for buffer in (self.source, self.target, self.total):
            self.layout.view(buffer)[cells_of(self._touched)] = 0
        self._forget()

    def _forget(self) -> None:
        self.lit = self._touched = nothing(self.layout.shape)
        self._limit = 0.0
        #: Cells swept since the start, and those of the whole grid in as many steps.
        self.swept = self.sweepable = 0
        self._looks = 0

    def start(self, newest: Patch, passed: Values | None, components: list[int]) -> None:
        """Begin with light in units of `scale`; `passed` (size, *shape) has moved on already.

        components: those whose sums over cells the books need.
        """
        self.reset()
        largest = float(np.abs(newest.values).max(initial=0.0)) if self.drop else 0.0
        self._limit = self.drop * largest
        everywhere = whole(self.layout.shape)
        newest = newest.trimmed()
        self.lit = newest.box if self.skip else everywhere
        self._touched = self.lit if passed is None else everywhere
        for buffer in (self.target, self.total):
            self.layout.view(buffer)[cells_of(newest.box)] = newest.values
        if passed is not None:
            self.layout.view(self.total)[...] += passed
        light = np.asarray(self.layout.view(self.target)[cells_of(newest.box)], float)
        self.start_norm = self.norm = float(np.sqrt(np.square(light).sum()))
        self._components = components
        axes = tuple(range(1, light.ndim))
        self.component_sums = light[components].sum(axis=axes)

    def take_over(self, other: LightState) -> None:
        """Go on where another one, of the same grid and scale, is; that one is dark from then on.

        If this one holds less of it, the rest must be its mirror image.
        """
        self.reset()
        for name in ("lit", "_touched"):
            box = other.whole_box(getattr(other, name))
            setattr(self, name, box if self.part is None else self.part.half_box(box))
        touched = cells_of(self._touched)
        for name in ("source", "target", "total"):
            light = other.cells(getattr(other, name))
            self.layout.view(getattr(self, name))[touched] = light[touched]
        for name in ("norm", "start_norm", "component_sums", "_components", "_limit", "_looks"):
            setattr(self, name, getattr(other, name))
        self.swept, self.sweepable = other.swept, other.sweepable
        other.reset()

    def lend(self) -> None:
        """Let others write anywhere in the buffers; the next reset clears them all."""
        self._touched = whole(self.layout.shape)

    def sums_of(self, buffer: Buffer, components: list[int]) -> NDArray[np.float64]:
        """Sums over cells of some components."""
        cells = self.layout.view(buffer)[components]
        return np.asarray(cells.sum(axis=tuple(range(1, cells.ndim)), dtype=float))

    @property
    def batch(self) -> int:
        """Steps that may run before the next look; no limit where nothing moves."""
        if is_empty(self.lit):
            return 1 << 30
        return BATCH if self.norm <= SUSPICIOUS_GROWTH * self.start_norm else 1

    def advance(self, count: int, sweep: AnySweep) -> StepSums:
        """`count` more steps."""
        self.sweepable += count * self._cells
        if is_empty(self.lit):
            count = 1  # for its report: many steps of no light are one
        if not self._is_full:
            # A step goes one cell far.
            self.lit = grown(self.lit, self.layout.shape, count)
            self._touched = hull(self._touched, self.lit)
        sums = self._move(count, sweep)
        self.swept += count * cell_count(self.lit)
        self.component_sums = sums.components[-1]
        self.norm = float(np.sqrt(sums.squares[-1]))
        return sums

    def _move(self, count: int, sweep: AnySweep) -> StepSums:
        """Steps inside the box, with the newest light in `target` after them."""
        sums = sweep.steps(self.target, self.source, self.total, count, self.lit)
        if count % 2:
            self.source, self.target = self.target, self.source
        return sums

    @property
    def _is_full(self) -> bool:
        return cell_count(self.lit) == self._cells

    def trim(self) -> float:
        """Shrink the box to the newest light; coefficient 0 of what was dropped with it."""
        self._looks += 1
        seldom = self._is_full and self._limit == 0 and self._looks % _SELDOM
        if not self.skip or seldom:
            return 0.0
        box, dropped = trimmed(self.layout.view(self.target), self.lit, self._limit)
        if box != self.lit:
            # The next step writes into what is the source now, and only inside the box.
            clear_outside(self.layout, self.source, self.lit, box)
            self.lit = box
        self.component_sums = self.component_sums - dropped[self._components]
        return float(dropped[0])

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

    def cells(self, buffer: Buffer) -> NDArray[np.floating]:
        """All cells (size, *shape) of one of the buffers, in units of `scale`.

        To be read only, before the run goes on: they may be the buffer's own.
        """
        light = self.layout.view(buffer)
        return light if self.part is None else self.part.whole(light)

    def light(self, name: str) -> Patch:
        """All that is lit of "source", "target" or "total"; to be read only."""
        box = self.whole_box(self._touched)
        return Patch(self.cells(getattr(self, name))[cells_of(box)], box)

    def whole_box(self, box: Box) -> Box:
        """The smallest box round a box of the buffers, and its images, in the whole grid."""
        return box if self.part is None else self.part.whole_box(box)

    def values(self, buffer: Buffer) -> NDArray[np.floating]:
        """The cells (size, *shape) of one of the buffers, scaled as the light really is."""
        return self.cells(buffer) * self.layout.dtype.type(self.scale)


def light_scale(pattern: Values) -> float:
    """The power of two just below the largest coefficient of a pattern of light; 1 without light.

    It changes no digit; fluxes of 1e30 W then do not overflow float32.
    """
    largest = float(np.abs(pattern).max(initial=0.0))
    return float(2.0 ** np.floor(np.log2(largest))) if largest > 0 else 1.0
