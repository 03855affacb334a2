"""Light that walls send back into the cell it came from: a sparse pass after a sweep.

A reflection touches only cells next to walls, so it stays out of the sweep itself: a run without
it does not pay for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
from flatland.kernels.orbits import significant
from flatland.kernels.reports import Buffer
from flatland.stencil import Stencil

Array = NDArray[np.float64]

#: Numbers of a cell's lobes up to which it does not matter how they are kept: a few cache lines.
_FEW = 64


@dataclass(frozen=True, eq=False)
class Reflection:
    """What cells get back of the light they send (Kaplanyan & Dachsbacher 2010, section 7).

    cells: (M, dimension), each once. lobes: (M, K, size), coefficients that cell m gets in the
    next step for a flux of coefficient 0 of one that it sends along offset d, before anything is
    stopped; lobes[m, d, 0] is the share that comes back, at most what is stopped.
    """

    cells: NDArray[np.int64]
    lobes: Array

    @property
    def key(self) -> bytes:
        """What makes two reflections the same."""
        return self.cells.tobytes() + self.lobes.tobytes()

    def blocks(self, stencil: Stencil) -> Array:
        """M(x) = Σ_d lobe(x, d) ⊗ T_d[0, :], (M, size, size): the local term of the operator."""
        return np.einsum("mdj,dk->mjk", self.lobes, sent_rows(stencil))


class Reflector:
    """A reflection on one layout: target(x) += Σ_d lobe(x, d) · (flux sent along d)."""

    def __init__(self, reflection: Reflection, stencil: Stencil, layout: Layout) -> None:
        self.stencil, self.stride = stencil, layout.component_stride
        self._index = layout.index(reflection.cells)
        self._copies = layout.copies(reflection.cells)
        self._rows = sent_rows(stencil)
        lobes = reflection.lobes
        # What a medium alone sends back is the same in all directions: no other component changes.
        used = np.flatnonzero(lobes.any(axis=(0, 1)))
        lobes = lobes[:, :, : used[-1] + 1 if used.size else 1]
        #: Whether cells are multiplied by blocks (M, C, size) or fluxes by lobes (M, C, K), with C
        #: the components that anything comes back in.
        whole = lobes.shape[2] == self._rows.shape[1]
        few = _are_smaller(self._rows.shape[::-1]) if whole else lobes.shape[2] == 1
        self._by_blocks = few and not stencil.clamp
        if self._by_blocks:
            self._factors = np.einsum("mdj,dk->mjk", lobes, self._rows)
        else:
            self._factors = np.ascontiguousarray(np.moveaxis(lobes, 1, 2))

    def add(self, source: Buffer, target: Buffer, factor: float) -> None:
        """target += factor · (what comes back of `source`)."""
        places = (self._index, self.stride, self._copies)
        _add(self._sent(source), self._factors, *places, factor, target, None)

    def step(self, source: Buffer, target: Buffer, total: Buffer) -> Array:
        """Add to the newest light and to the total; returns changes (size + 2,) of their sums.

        Per component; of the sum of all squares; and the flux that came back.
        """
        sent = self._sent(source)
        places = (self._index, self.stride, self._copies)
        found = _add(sent, self._factors, *places, 1.0, target, total)
        changes = np.zeros(self._rows.shape[1] + 2)
        changes[: found.size - 2], changes[-2:] = found[:-2], found[-2:]
        return changes

    def _sent(self, source: Buffer) -> Array:
        """Flux (M, K), in units of coefficient 0, that the cells send along each offset; or their
        light (M, size), where the factors are blocks."""
        if not (self.stencil.clamp or self._by_blocks):
            return np.asarray(_linear_fluxes(source, self._index, self.stride, self._rows))
        places = self._index[:, None] + self.stride * np.arange(self._rows.shape[1])
        light = source[places].astype(float)
        if self._by_blocks:
            return light
        assert self.stencil.reception is not None
        assert self.stencil.emission is not None
        faces = np.einsum("dfk,mk->mdf", self.stencil.reception, light)
        return np.einsum("df,mdf->md", self.stencil.emission[:, 0], np.maximum(faces, 0.0))


def sent_rows(stencil: Stencil) -> Array:
    """T_d[0, :], (K, size): flux sent along each offset per unit of each coefficient."""
    return np.ascontiguousarray(significant(stencil.transfer)[:, 0, :])


def _are_smaller(shape: tuple[int, ...]) -> bool:
    """Whether a cell's block (size, size) is worth having beside its lobes (size, K)."""
    size, offsets = shape
    return size < offsets and size * offsets > _FEW


@njit(cache=True, error_model="numpy", nogil=True)
def _linear_fluxes(source, index, stride, rows):  # type: ignore[no-untyped-def]
    fluxes = np.zeros((index.size, rows.shape[0]))
    for m in range(index.size):
        for k in range(rows.shape[1]):
            light = float(source[index[m] + k * stride])
            for d in range(rows.shape[0]):
                fluxes[m, d] += rows[d, k] * light
    return fluxes


@njit(cache=True, error_model="numpy", nogil=True)
def _add(  # type: ignore[no-untyped-def]
    sent, factors, index, stride, copies, factor, target, total
):
    size = factors.shape[1]
    report = np.zeros(size + 2)
    for m in range(index.size):
        for k in range(size):
            share = 0.0
            for d in range(sent.shape[1]):
                share += factors[m, k, d] * sent[m, d]
            at = index[m] + k * stride
            old = float(target[at])
            target[at] += factor * share
            # What float32 really added, so that the books agree with the field.
            new = float(target[at])
            if total is not None:
                total[at] += factor * share
            report[k] += copies[m] * (new - old)
            report[size] += copies[m] * (new * new - old * old)
    report[size + 1] = report[0]
    return report
