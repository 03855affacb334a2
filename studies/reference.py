"""The exact answer of a scene, computed once and compared with many."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from flatland.memory import require_memory
from flatland.scene import Scene
from flatland.sources import ParallelSource
from propagators import create

Array = NDArray[np.float64]

#: Directions at which the exact intensity is sampled. Its kinks in angle make the measured angular
#: error converge as 1/K²; at 256 it is good to about 1e-4 of itself.
DIRECTIONS = 256


class Reference:
    """The analytic field at any number of bands and the intensity it was cut from.

    bounces: whether walls send light back. What it cannot do: scenes that the analytic propagator
    refuses, see there; and parallel light is a delta in angle, which `intensity` leaves out.
    """

    def __init__(self, scene: Scene, directions: int = DIRECTIONS, bounces: bool = True) -> None:
        self.scene, self.count = scene, directions
        self._propagator = create("analytic", bounces=bounces)
        self._fields: dict[int, Field] = {}

    def field(self, bands: int) -> Field:
        """The exact coefficients for n bands."""
        known = [n for n in self._fields if n >= bands]
        if not known:
            self._fields[bands] = self._propagator.solve(self.scene, bands)
            return self._fields[bands]
        return self._fields[min(known)].with_bands(bands)

    @property
    def has_density(self) -> bool:
        """Whether all light has an intensity over angle; parallel light has not."""
        sources = self.scene.sources("lamp")
        return not any(isinstance(source, ParallelSource) for source in sources)

    @cached_property
    def directions(self) -> Array:
        """Unit vectors (K, 2), half a step off the axes, where intensities may jump."""
        angles = (np.arange(self.count) + 0.5) * (2 * np.pi / self.count)
        return np.stack([np.cos(angles), np.sin(angles)], axis=-1)

    @cached_property
    def intensity(self) -> Array:
        """Exact I_ref ([colours,] K, nx, ny), not band-limited."""
        needed = 8 * self.count * self.scene.grid.cell_count * max(1, self.scene.colours)
        require_memory(3 * needed, "grid.shape", self.scene.grid.shape)
        return np.asarray(self._propagator.intensity(self.scene, self.directions))  # type: ignore[attr-defined]
