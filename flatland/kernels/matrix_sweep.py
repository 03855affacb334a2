"""The sweep as matrix products, for more coefficients than can be written out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
from flatland.kernels.mirroring import Mirrors
from flatland.kernels.reports import StepSums
from flatland.stencil import Stencil

Buffer = NDArray[np.floating]

#: Numbers of one component handled at once: source and target blocks of 100 coefficients stay
#: in a 1 MB cache.
_BLOCK = 1024


class MatrixSweep:
    """T = Σ_d T_d (τ_d S)(x − d): in a layout with a border, a step to a neighbour is a shift."""

    def __init__(self, stencil: Stencil, layout: Layout, transmittance: Buffer | None) -> None:
        self.layout, self.transmittance = layout, transmittance
        self.matrices = stencil.transfer.astype(layout.dtype)
        self.offsets = stencil.offsets
        self.stencil = stencil
        self._open = replace(layout, components=len(stencil.offsets))

    def apply(self, source: Buffer, target: Buffer) -> None:
        """Write A S into `target`; its border stays zero."""
        *planes, rows = self.layout.shape[:-1]
        count = max(1, _BLOCK // self.layout.component_stride)
        for plane in np.ndindex(*planes):
            for first in range(0, rows, count):
                cells = np.array([*plane, first, 0])
                self._block(source, target, cells, min(count, rows - first))

    def steps(
        self,
        source: Buffer,
        target: Buffer,
        total: Buffer,
        count: int,
        sums: Sequence[int],
        outflow: Callable[[Buffer], float],
        mirrors: Mirrors | None,
    ) -> StepSums:
        """See `Sweep.steps`. sums: components to report. outflow: what leaves the grid."""
        rows = np.zeros((count, len(sums) + 2))
        for row in rows:
            row[-1] = outflow(source)
            self.apply(source, target)
            total += target
            cells = self.layout.view(target)
            row[: len(sums)] = cells[list(sums)].sum(tuple(range(1, cells.ndim)), dtype=float)
            row[-2] = np.square(cells).sum(dtype=float)
            if mirrors is not None:
                mirrors.fill(target, row)
            source, target = target, source
        return StepSums(rows[:, :-2], rows[:, -2], rows[:, -1])

    def _block(self, source: Buffer, target: Buffer, cells: NDArray[np.int64], rows: int) -> None:
        """Some rows of one plane, the first of which begins in the cell `cells`."""
        arrived = _rows(self.layout, target, cells, rows)
        arrived[...] = 0
        for d in range(len(self.offsets)):
            arrived += self._arriving(source, d, cells - self.offsets[d], rows)

    def _arriving(self, source: Buffer, d: int, cells: NDArray[np.int64], rows: int) -> Buffer:
        light = _rows(self.layout, source, cells, rows)
        if self.transmittance is not None:
            light = light * _rows(self._open, self.transmittance, cells, rows)[:, d, None]
        if not self.stencil.clamp:
            return np.asarray(self.matrices[d] @ light)
        assert self.stencil.reception is not None
        assert self.stencil.emission is not None
        flux = np.maximum(self.stencil.reception[d].astype(light.dtype) @ light, 0)
        return np.asarray(self.stencil.emission[d].astype(light.dtype) @ flux)


def _rows(layout: Layout, buffer: Buffer, cells: NDArray[np.int64], rows: int) -> Buffer:
    """Rows one after another, (rows, components, width), from a cell that may lie in the border."""
    at = layout.front + layout.shift(cells)
    strides = (layout.strides[-2], layout.component_stride, 1)
    return np.lib.stride_tricks.as_strided(
        buffer[at:],
        (rows, layout.components, layout.width),
        tuple(buffer.itemsize * step for step in strides),
    )
