"""The exact answer of a scene, computed once and compared with many."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.field import Field
from flatland.memory import require_memory
from flatland.scene import Scene
from flatland.sources import ParallelSource
from propagators import create

Array = NDArray[np.float64]

#: Directions at which the exact intensity is sampled, by dimension. Its kinks in angle make the
#: measured angular error of 2D converge as 1/K²; at 256 it is good to about 1e-4 of itself. In 3D
#: edges of shadows are lines on the sphere: at 1024 the floor of a square light in free space is
#: good to 6e-4 of itself for 4 bands, to 1.4e-3 for 6.
DIRECTIONS = {2: 256, 3: 1024}


class Reference:
    """The analytic field at any number of bands and the intensity it was cut from.

    directions: how many to sample, by default DIRECTIONS. bounces: whether walls send light back.
    What it cannot do: scenes that the analytic propagator refuses, see there; and parallel light
    is a delta in angle, which `intensity` leaves out.
    """

    def __init__(self, scene: Scene, directions: int | None = None, bounces: bool = True) -> None:
        self.scene = scene
        self.count = directions or DIRECTIONS[scene.grid.dimension]
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
        """Unit vectors (K, dimension), evenly spread."""
        return even_directions(self.scene.grid.dimension, self.count)

    @cached_property
    def intensity(self) -> Array:
        """Exact I_ref ([colours,] K, *shape) at `directions`, not band-limited."""
        return self.intensity_at(self.directions)

    def intensity_at(self, directions: ArrayLike) -> Array:
        """Exact I_ref ([colours,] K, *shape) at unit directions (K, dimension)."""
        count = len(np.asarray(directions))
        needed = 8 * count * self.scene.grid.cell_count * max(1, self.scene.colours)
        require_memory(3 * needed, "grid.shape", self.scene.grid.shape)
        return np.asarray(self._propagator.intensity(self.scene, directions))  # type: ignore[attr-defined]


def even_directions(dimension: int, count: int) -> Array:
    """Unit vectors (count, dimension), each of which stands for the same angle.

    In 2D half a step off the axes, where intensities may jump. In 3D a Fibonacci lattice: heights
    evenly spaced, each turned on by the golden angle (Swinbank & Purser 2006). Of the mean of a
    function that jumps across a line it misses about count^(-3/4), where random directions miss
    count^(-1/2).
    """
    steps = np.arange(count, dtype=np.float64) + 0.5
    if dimension == 2:
        return _circle(steps * (2 * np.pi / count))
    height = 1 - 2 * steps / count
    golden_angle = np.pi * (3 - np.sqrt(5))
    around = np.sqrt(1 - height**2)[:, None] * _circle(steps * golden_angle)
    return np.concatenate([around, height[:, None]], axis=1)


def _circle(angles: Array) -> Array:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)
