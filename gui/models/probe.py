"""The numbers of one cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from gui.models.plane import Plane, grey

Array = NDArray[np.float64]
#: Directions at which a cell's intensity is drawn and searched for its extremes.
DIRECTIONS = 360


@dataclass(frozen=True, eq=False)
class Probe:
    """One cell of a field. flux: of each colour, or one [W]. net: vector flux (dimension,) [W].

    lowest, highest: of the intensity over all directions [W per unit angle], colours added up.
    coefficients: (size,), colours added up. curve: intensity over directions in the plane.
    """

    cell: tuple[int, ...]
    flux: tuple[float, ...]
    net: Array
    lowest: float
    highest: float
    coefficients: Array
    curve: Array


def probe(field: Field, cell: tuple[int, ...], plane: Plane, channel: int | None = None) -> Probe:
    """What a field holds in a cell; the channel's light alone if one is given."""
    basis, dimension = field.basis, field.grid.dimension
    index: Any = (..., *cell)
    values: Array = np.asarray(grey(field, channel)[index], np.float64)
    flux: Array = np.atleast_1d(np.asarray(field.values[index], np.float64)[..., 0])
    flux = flux * basis.flux_weight
    angles = np.arange(DIRECTIONS, dtype=float) * (2 * np.pi / DIRECTIONS)
    curve = basis.evaluate(plane.directions(angles, dimension)) @ values
    everywhere = curve
    directions, weights = basis.quadrature(max(2 * basis.bands, 32))
    if dimension == 3:
        everywhere = np.concatenate([curve, basis.evaluate(directions) @ values])
    net = (weights * (basis.evaluate(directions) @ values)) @ directions
    return Probe(
        cell,
        tuple(float(x) for x in flux),
        net if basis.bands > 1 else np.zeros(dimension),
        float(everywhere.min()),
        float(everywhere.max()),
        values,
        curve,
    )


def told(found: Probe, dimension: int) -> list[tuple[str, str]]:
    """Names and values with their units, for a table."""
    unit = "W/rad" if dimension == 2 else "W/sr"
    shown = " ".join(f"{x:.4g}" for x in found.flux)
    length = float(np.hypot.reduce(found.net))
    vector = ", ".join(f"{x:.3g}" for x in found.net)
    return [
        ("Cell", ", ".join(map(str, found.cell))),
        ("Flux", f"{shown} W"),
        ("Net flux", f"{length:.4g} W  ({vector})"),
        ("Smallest", f"{found.lowest:.4g} {unit}"),
        ("Largest", f"{found.highest:.4g} {unit}"),
    ]
