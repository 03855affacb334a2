"""The books of clamped steps, whose fluxes the transfer matrices do not give."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.box import Box
from flatland.kernels.layout import Layout
from flatland.kernels.reports import Buffer, StepSums

if TYPE_CHECKING:
    from flatland.kernels.sweep import Sweep


def clamped_steps(
    sweep: Sweep,
    source: Buffer,
    target: Buffer,
    total: Buffer,
    count: int,
    lit: Box | None = None,
) -> StepSums:
    """Steps one by one, with the flux that was sent and that left counted after clamping."""
    reports = []
    for _ in range(count):
        sent, left = _sent_and_left(sweep, source)
        report = sweep.plain_steps(source, target, total, 1, lit)
        reports.append(replace(report, sent=np.array([sent]), left=np.array([left])))
        source, target = target, source
    return StepSums.joined(reports)


def _sent_and_left(sweep: Sweep, source: Buffer) -> tuple[float, float]:
    """In units of coefficient 0: flux that cells send, and the part that goes over the border."""
    stencil, layout = sweep.stencil, sweep.layout
    assert stencil.reception is not None
    assert stencil.emission is not None
    light, cells = layout.view(source), (..., *map(slice, layout.shape))
    copies = layout.copies(np.argwhere(np.ones(layout.shape))).reshape(layout.shape)
    sent = left = 0.0
    for d, offset in enumerate(stencil.offsets):
        fluxes = np.maximum(np.tensordot(stencil.reception[d], light, 1), 0.0)
        flux = np.tensordot(stencil.emission[d, 0], fluxes, 1) * copies
        sent += float(flux.sum())
        passing = flux if sweep.open_share is None else flux * sweep.open_share[d][cells]
        left += float(passing.sum() - passing[_staying(layout, offset)].sum())
    return sent, left


def _staying(layout: Layout, offset: NDArray[np.int64]) -> tuple[slice, ...]:
    """Cells whose neighbour at `offset` is in the grid, or in the mirror."""
    sides = zip(layout.shape, layout.ghosts, offset)
    return tuple(slice(max(0, -o), n - max(0, o - ghosts)) for n, ghosts, o in sides)
