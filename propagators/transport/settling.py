"""Light between walls, for schemes that know no exchange but can send light once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres

from flatland.errors import ConvergenceError

Array = NDArray[np.float64]

#: Relative residual asked of the solver; an answer with a hundred times as much is refused.
RESIDUAL = 1e-10
#: Bounces one by one at which light is given up that does not settle.
MOST_BOUNCES = 1000


def settled_flux(
    send: Callable[[Array], Array], albedo: Array, direct: Array, residual: float = RESIDUAL
) -> Array:
    """Flux (E, 2, C) that sides of elements send back in the end, all bounces.

    send: flux that arrives on each side (E, 2, C) of what all sides send (E, 2, C); linear.
    albedo: (E, C). direct: (E, 2, C), what arrives from the lights.
    residual: relative, to stop at. Solves b = ρ (P + X b) by GMRES, a dozen sends or two.
    Raises ConvergenceError where light never ends: a closed room of albedo 1.
    """
    share = np.repeat(albedo[:, None], 2, axis=1)
    sends = share > 0
    source = (share * direct)[sends]
    norm = float(np.linalg.norm(source))
    result = np.zeros(direct.shape)
    if norm == 0.0:
        return result

    def apply(vector: Array) -> Array:
        sent = np.zeros(direct.shape)
        sent[sends] = vector.ravel()
        return np.asarray(vector.ravel() - (share * send(sent))[sends])

    operator = LinearOperator((source.size, source.size), apply, dtype=float)
    found, _ = gmres(operator, source / norm, rtol=residual, atol=0.0, restart=60, maxiter=5)
    _require_settled(float(np.linalg.norm(source / norm - apply(found))), 100 * residual)
    result[sends] = found * norm
    return result


def iterated_flux(arrive: Callable[[Array], Array], albedo: Array) -> Array:
    """The same, bounce by bounce: for sending that is not linear, or with the lights in it.

    arrive: flux (E, 2, C) that arrives in all, of the lights and of what walls send (E, 2, C).
    """
    sent = np.zeros((len(albedo), 2, albedo.shape[1]))
    change = size = 0.0
    for _ in range(MOST_BOUNCES):
        newer = albedo[:, None] * arrive(sent)
        change, size = float(np.linalg.norm(newer - sent)), float(np.linalg.norm(newer))
        sent = newer
        if change <= RESIDUAL * size:
            break
    _require_settled(change / size if size else 0.0, 100 * RESIDUAL)
    return sent


def _require_settled(residual: float, worst: float) -> None:
    if not residual <= worst:
        raise ConvergenceError(
            f"light between walls did not settle (residual {residual:.1e}): "
            "in a closed room its albedo must be below 1"
        )
