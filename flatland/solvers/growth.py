"""Whether walls make light grow that a scheme alone would not."""

from __future__ import annotations

import numpy as np

from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.reports import Buffer
from flatland.solvers.vectors import norm
from flatland.solvers.watching import applied

#: Flux below zero, against the largest, that ringing of few bands does not explain (0.1 of DOM8).
_NEGATIVE = 0.25
#: Steps between two looks, and looks at most.
_STEPS, _LOOKS = 32, 16
#: Two looks that agree this well have found the factor.
_SETTLED = 1e-5


def may_grow(sweep: AnySweep, answer: Buffer) -> bool:
    """Whether a solution of (1 − A) S_A = S_0 may be no sum of light, from cheap signs.

    Only reflecting walls can make it so. What grows by λ > 1 a step is in the solution with the
    factor 1/(1 − λ) < 0, so that flux is negative. What grows by λ < −1 leaves no trace there: it
    was seen in cells with walls all around, by what comes back of their own light.

    What it gets wrong: growth that swings over several cells is not seen.
    """
    if sweep.reflection is None:
        return False
    flux = sweep.layout.view(answer)[0]
    if flux.min(initial=0.0) < -_NEGATIVE * np.abs(flux).max(initial=0.0):
        return True
    blocks = sweep.reflection.blocks(sweep.stencil)
    # A block's radius is at most its largest row sum, which few cells exceed.
    blocks = blocks[np.abs(blocks).sum(axis=2).max(axis=1, initial=0.0) > 1]
    return bool(np.abs(np.linalg.eigvals(blocks)).max(initial=0.0) > 1 + _SETTLED)


def growth_factor(sweep: AnySweep, light: Buffer) -> float:
    """Factor by which a step multiplies this light in the long run, if above 1; else 0.

    By the power method: what grows outlives the rest.
    """
    light, other = light.copy(), np.zeros_like(light)
    before = factor = 0.0
    for _ in range(_LOOKS):
        size = norm(light)
        if size == 0:
            return 0.0
        light /= size
        for _ in range(_STEPS):
            sweep.combine(0.0, 0.0, 1.0, light, light, other)
            light, other = other, light
        applied(_STEPS)
        before, factor = factor, norm(light) ** (1 / _STEPS)
        if abs(factor - before) < _SETTLED and factor > 1:
            break
    return factor if factor > 1 + _SETTLED else 0.0
