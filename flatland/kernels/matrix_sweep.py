"""The sweep as matrix products, for more coefficients than can be written out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
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
        self.shifts = [layout.shift(offset) for offset in stencil.offsets]
        self.stencil = stencil

    def apply(self, source: Buffer, target: Buffer) -> None:
        """Write A S into `target`; its border stays zero."""
        layout = self.layout
        for start in range(0, layout.component_stride, _BLOCK):
            stop = min(start + _BLOCK, layout.component_stride)
            block = layout.body(target)[:, start:stop]
            block[...] = 0
            for d, shift in enumerate(self.shifts):
                block += self._arriving(source, d, start - shift, stop - start)
        kept = layout.view(target).copy()
        layout.body(target)[...] = 0
        layout.view(target)[...] = kept

    def _arriving(self, source: Buffer, d: int, start: int, count: int) -> Buffer:
        light = _window(self.layout, source, self.layout.components, start, count)
        if self.transmittance is not None:
            at = self.layout.front + d * self.layout.component_stride + start
            light = light * self.transmittance[at : at + count]
        if not self.stencil.clamp:
            return np.asarray(self.matrices[d] @ light)
        assert self.stencil.reception is not None
        assert self.stencil.emission is not None
        flux = np.maximum(self.stencil.reception[d].astype(light.dtype) @ light, 0)
        return np.asarray(self.stencil.emission[d].astype(light.dtype) @ flux)


def _window(layout: Layout, buffer: Buffer, components: int, start: int, count: int) -> Buffer:
    """Components (components, count) of consecutive positions, which may begin in the border."""
    at = layout.front + start
    step = buffer.itemsize
    return np.lib.stride_tricks.as_strided(
        buffer[at:], (components, count), (layout.component_stride * step, step), writeable=False
    )
