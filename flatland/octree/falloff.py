r"""How fast light fades on a level, per metre and not per cell.

A scheme that loses light with every step (a propagation factor below 1, the published LPV) loses
it per cell: on level i, whose cells are 2^i times as large, light gets 2^i times as far. The octree
thesis asks (7.1) for factors p_i, derived from the global p, that make it fade alike on all levels.
They follow from the scheme itself. Far from its source, light accumulates to S(x) = v e^{−μ x}
along an axis, which a step must map to itself:

    v = A(μ) v,  A(μ) = Σ_d T_d e^{μ d_x},  so  λ(μ) = 1,

λ the largest eigenvalue of A. That is the symbol of the scheme at an imaginary wave vector. μ is
the fading per cell of level 0; level i must fade by 2^i μ per cell, and does if its steps are
multiplied by

    g_i = λ(μ) / λ(2^i μ) = 1 / λ(2^i μ).

For light that runs straight, λ(μ) = p e^μ: g_i p = p^{2^i}, the power of p that one expects. For a
random walk with little loss, λ ≈ p (1 + κ μ²): 1 − p_i ≈ 4^i (1 − p), which is much more.
What it gets wrong: other directions than along an axis; and light near its source fades by other
modes.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from flatland.stencil import Stencil

FALLOFFS = ("cells", "metres")
#: A scheme whose light fades by less than this per step is taken to keep all of it.
_LOSSLESS = 1e-12


def fading(stencil: Stencil) -> float:
    """μ per cell along the first axis, of light far from its source; 0 if steps lose none."""
    if _log_growth(stencil, 0.0) > -_LOSSLESS:
        return 0.0
    upper = 1.0
    while _log_growth(stencil, upper) < 0:
        upper *= 2
        if upper > 1e6:
            return math.inf  # nothing goes along this axis
    return float(brentq(lambda mu: _log_growth(stencil, mu), 0.0, upper, xtol=1e-14))


def step_factors(stencil: Stencil, levels: int, falloff: str) -> tuple[float, ...]:
    """What multiplies the steps of each level, 1 for level 0."""
    mu = fading(stencil) if falloff == "metres" else 0.0
    if mu == 0.0:
        return (1.0,) * levels
    coarse = [math.exp(-_log_growth(stencil, mu * 2**level)) for level in range(1, levels)]
    return (1.0, *coarse)


def _log_growth(stencil: Stencil, mu: float) -> float:
    """ln λ(μ); the largest exponential is taken out, so that nothing overflows."""
    if math.isinf(mu):
        return math.inf
    weights = np.exp(mu * (stencil.offsets[:, 0] - 1.0))
    matrix = np.tensordot(weights, stencil.transfer, axes=1)
    size = float(np.abs(np.linalg.eigvals(matrix)).max())
    return mu + math.log(size) if size > 0 else -math.inf
