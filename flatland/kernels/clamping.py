"""The books of clamped steps, whose fluxes the transfer matrices do not give."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels.box import Box, cells_of, whole
from flatland.kernels.layout import Layout
from flatland.kernels.reports import Buffer, StepSums
from flatland.stencil import Stencil

if TYPE_CHECKING:
    from flatland.kernels.sweep import Sweep

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Links:
    """Ways out of cells. at: positions (L,) of component 0. along: offsets (L,). share: (L,)."""

    at: NDArray[np.int64]
    along: NDArray[np.int64]
    share: Array

    @classmethod
    def where(cls, share: Array, layout: Layout) -> _Links:
        """Those of share (K, *shape) that are not zero; cells on a mirror count half."""
        places = np.argwhere(share)
        cells, shares = places[:, 1:], share[tuple(places.T)]
        return cls(layout.index(cells), places[:, 0], shares * layout.copies(cells))


class ClampedFluxes:
    """What a clamped step sends out of the grid and into walls, in units of coefficient 0.

    Only cells at the border and next to walls are looked at: what all cells send is what arrives,
    and these.
    """

    def __init__(self, stencil: Stencil, layout: Layout, transmittance: Array | None) -> None:
        assert stencil.reception is not None
        assert stencil.emission is not None
        self._reception = np.ascontiguousarray(stencil.reception)
        self._emission = np.ascontiguousarray(stencil.emission[:, 0])
        self._stride = layout.component_stride
        leaving = np.ones((len(stencil.offsets), *layout.shape))
        for share, offset in zip(leaving, stencil.offsets):
            share[_staying(layout, offset)] = 0.0
        stopped = None
        if transmittance is not None:
            passing = transmittance[cells_of(whole(layout.shape))]
            stopped = _Links.where(1.0 - passing, layout)
            leaving *= passing
        self._leaving, self._stopped = _Links.where(leaving, layout), stopped

    def left(self, source: Buffer) -> float:
        return self._sum(source, self._leaving)

    def stopped(self, source: Buffer) -> float:
        return 0.0 if self._stopped is None else self._sum(source, self._stopped)

    def _sum(self, source: Buffer, links: _Links) -> float:
        factors = self._reception, self._emission
        return float(_flux(source, links.at, links.along, links.share, *factors, self._stride))


def clamped_steps(
    sweep: Sweep,
    source: Buffer,
    target: Buffer,
    total: Buffer,
    count: int,
    lit: Box | None = None,
) -> StepSums:
    """Steps one by one, with the flux that was sent and that left counted after clamping."""
    reports, flux = [], sweep.recipe.sums.index(0)
    for _ in range(count):
        left, stopped = sweep.clamped.left(source), sweep.clamped.stopped(source)
        report = sweep.plain_steps(source, target, total, 1, lit)
        sent = report.components[:, flux] + left + stopped
        reports.append(replace(report, sent=sent, left=np.array([left])))
        source, target = target, source
    return StepSums.joined(reports)


def _staying(layout: Layout, offset: NDArray[np.int64]) -> tuple[slice, ...]:
    """Cells whose neighbour at `offset` is in the grid, or in the mirror."""
    sides = zip(layout.shape, layout.ghosts, offset)
    return tuple(slice(max(0, -o), n - max(0, o - ghosts)) for n, ghosts, o in sides)


@njit(cache=True, error_model="numpy", nogil=True)
def _flux(source, at, along, share, reception, emission, stride):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(at.size):
        d = along[i]
        flux = 0.0
        for f in range(emission.shape[1]):
            onto = 0.0
            for k in range(reception.shape[2]):
                onto += reception[d, f, k] * source[at[i] + k * stride]
            if onto > 0.0:
                flux += emission[d, f] * onto
        total += share[i] * flux
    return total
