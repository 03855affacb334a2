"""Light that walls send to one another, along the same ordinates that carry it to the cells.

With the flux b per length that each side of an element sends, l its length, ρ its albedo, P what
arrives from the lights and X_ij what i gets of the radiance b_j/2 of j,

    l_i b_i / ρ_i = P_i + Σ_j X_ij b_j / 2.

What an element emits is scaled so that the sum over the ordinates is exact (`emission_scale`): its
radiance is s b/2 = u/2. Every ordinate has its opposite in the set, so X is symmetric, and with
l/(ρ s) u = P + X u/2 so is what conjugate gradients solve. Unlike the exchange of the reference, X
comes from the beams.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, dia_array, eye_array
from scipy.sparse.linalg import cg

from flatland.errors import ConvergenceError
from propagators.beam.flight import Transport

Array = NDArray[np.float64]

#: Relative residual asked of the solver, and the one beyond which its answer is refused.
RESIDUAL, WORST_RESIDUAL = 1e-14, 1e-11


def reflected_radiance(transport: Transport, scale: Array, direct: Array) -> Array:
    """Scaled radiance (E, 2, C) of light that walls send back, all bounces.

    scale: (E,) of the emission. direct: (E, 2, C), flux from the lights.
    Raises ConvergenceError where light never ends: a closed room of albedo 1.
    """
    albedo = transport.surfaces.albedo
    exchange = transport.exchange(np.repeat(np.any(albedo > 0, axis=1)[:, None], 2, axis=1))
    result = np.empty(direct.shape)
    for colour in range(direct.shape[2]):
        factor = np.repeat(np.sqrt(albedo[:, colour] * scale / transport.surfaces.lengths), 2)
        source = factor * direct[:, :, colour].ravel()
        found = _solved(exchange, factor, source)
        result[:, :, colour] = (0.5 * factor * found).reshape(-1, 2)
    return result


def _solved(exchange: csr_array, factor: Array, source: Array) -> Array:
    """(1 - f X f / 2) y = source."""
    norm = float(np.linalg.norm(source))
    if norm == 0.0:
        return np.zeros(source.size)
    scaled = dia_array((factor[None], 0), shape=exchange.shape)
    matrix = csr_array(scaled @ exchange @ scaled * -0.5)
    matrix = csr_array(matrix + eye_array(factor.size))
    found, _ = cg(matrix, source / norm, rtol=RESIDUAL, maxiter=1000)
    residual = float(np.linalg.norm(source / norm - matrix @ found))
    if not residual <= WORST_RESIDUAL:
        raise ConvergenceError(
            f"light between walls did not settle (residual {residual:.1e}): "
            "in a closed room its albedo must be below 1"
        )
    return np.asarray(found * norm)
