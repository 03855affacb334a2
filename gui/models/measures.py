"""Errors of a field against the exact one, as the octree thesis plots them (its figure 11)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field

#: What is measured per iteration: key, meaning.
ERRORS = {
    "mean_absolute": "mean over cells of the infinity norm of the difference [W per unit angle]",
    "max_absolute": "largest over cells of the infinity norm of the difference [W per unit angle]",
    "mean_relative": "mean over lit cells of that norm, as a share of the exact cell's",
    "max_relative": "largest over lit cells of that norm, as a share of the exact cell's",
    "coefficients": "relative L2 over all coefficients and cells",
}


def errors_of(field: Field, exact: Field) -> dict[str, float]:
    """All of ERRORS, colours together; the means are those of studies.metrics.

    Relative ones leave out cells that are dark in the exact field.
    """
    difference = np.asarray(field.values, float) - exact.values
    norms, sizes = _infinity(difference, field), _infinity(exact.values, field)
    lit = sizes > 0
    shares = norms[lit] / sizes[lit]
    length = float(np.linalg.norm(exact.values))
    return {
        "mean_absolute": float(norms.mean()),
        "max_absolute": float(norms.max()),
        "mean_relative": float(shares.mean()) if shares.size else 0.0,
        "max_relative": float(shares.max()) if shares.size else 0.0,
        "coefficients": float(np.linalg.norm(difference)) / length if length else float("nan"),
    }


def _infinity(values: NDArray[np.floating], field: Field) -> NDArray[np.float64]:
    """Largest size of the coefficients, one per colour and cell."""
    return np.asarray(np.abs(values).max(axis=-1 - field.grid.dimension), float)
