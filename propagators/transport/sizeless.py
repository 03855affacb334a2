"""Lights that no ray can hit, points and parallel light: their first flight in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics
from flatland.ledger import Ledger
from propagators.analytic.balance import balance
from propagators.analytic.geometry import Geometry
from propagators.analytic.lighting import collect_all

Array = NDArray[np.float64]


def first_flight(geometry: Geometry, bands: int) -> Array:
    """Coefficients (C, size, nx, ny) of what leaves each cell of all lights' light, unreflected."""
    basis = CircularHarmonics(bands)
    moments = collect_all(geometry, geometry.cell_outlines(), bands)
    moments /= np.where(basis.degrees > 0, np.sqrt(np.pi), np.sqrt(2 * np.pi))
    values = moments.reshape(*geometry.grid.shape, -1, basis.size)
    return np.ascontiguousarray(values.transpose(2, 3, 0, 1))


@dataclass(frozen=True, eq=False)
class SizelessLights:
    """Points and parallel light of a scene; walls in their way are those of the whole scene."""

    geometry: Geometry

    @classmethod
    def of(cls, geometry: Geometry) -> SizelessLights | None:
        """What is left of a scene without its segments that shine; None if nothing is."""
        if not (len(geometry.positions) or len(geometry.directions)):
            return None
        colours = geometry.radiance.shape[1]
        dark = replace(geometry, emitters=np.empty((0, 4)), radiance=np.empty((0, colours)))
        return cls(dark)

    def field(self, bands: int) -> Array:
        """Coefficients (C, size, nx, ny) of what leaves each cell."""
        return first_flight(self.geometry, bands)

    def arriving(self, targets: Array) -> Array:
        """Flux (K, C) on the left of targets (K, 4)."""
        groups = np.ascontiguousarray(targets[:, None])
        return collect_all(self.geometry, groups, 1)[:, :, 0]

    def books(self) -> Ledger:
        """Entries (C,). absorbed: without the share that walls send back."""
        return balance(self.geometry, True)
