"""An error measure of one's own: by what angle does a scheme turn the flow of light?"""

from __future__ import annotations

import numpy as np

from flatland.field import Field
from studies.metrics import Mask


def turned(field: Field, reference: Field, mask: Mask = None) -> float:
    """Mean angle [rad] between net fluxes, weighted by the reference's; NaN for one band.

    0 for equal fields; π/2 for a field that flows nowhere in particular. Grey fields only.
    """
    if field.basis.bands < 2:
        return float("nan")
    flows, exact = field.net_flux(), reference.net_flux()
    lengths, weights = np.linalg.norm(flows, axis=0), np.linalg.norm(exact, axis=0)
    cosines = (flows * exact).sum(axis=0) / np.maximum(lengths * weights, np.finfo(float).tiny)
    chosen = np.ones(field.grid.shape, bool) if mask is None else mask
    angles = np.arccos(np.clip(cosines, -1, 1))
    return float(np.average(angles[chosen], weights=weights[chosen]))
