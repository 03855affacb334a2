"""Discrete ordinates on the circle: M directions, evenly spread, of equal weight.

θ_k = (k + offset) 2π/M. At offset 1/2 no ordinate lies on an axis if M is a multiple of 4. M is
even, so that with every direction comes its opposite.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.harmonics import CircularHarmonics

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ordinates:
    """count: M, a multiple of 4. offset: of the first one, in steps."""

    count: int
    offset: float = 0.5

    @property
    def weight(self) -> float:
        """Angle [rad] that each stands for."""
        return 2 * np.pi / self.count

    @property
    def angles(self) -> Array:
        return np.asarray((np.arange(self.count) + self.offset) * self.weight, float)

    @property
    def directions(self) -> Array:
        """Unit vectors (M, 2); exact on the axes."""
        vectors: Array = np.stack([np.cos(self.angles), np.sin(self.angles)], axis=-1)
        vectors[np.abs(vectors) < 1e-15] = 0.0
        return vectors

    def harmonics(self, basis: CircularHarmonics) -> Array:
        """Weights times basis functions (M, size): coefficients are the sum over ordinates."""
        return self.weight * basis.evaluate_angles(self.angles)

    def emission_scale(self, segments: Array) -> Array:
        """Factor (S,) that makes what Lambertian segments (S, 4) emit exact in sum.

        2 / Σ_k 2π/M max(0, n·ω_k), in closed form: the ordinates on one side of a segment are at
        angles α + k δ from it, δ = 2π/M, and Σ sin(α + k δ) = cos(α - δ/2) / sin(δ/2). Without it,
        what an ordinate set emits is off by up to (π/M)²/3.
        """
        extent = segments[:, 2:] - segments[:, :2]
        turns = np.arctan2(extent[:, 1], extent[:, 0]) / self.weight - self.offset
        first = np.ceil(turns) - turns  # α/δ
        half = self.weight / 2
        return np.asarray(np.sin(half) / half / np.cos((2 * first - 1) * half))


def chosen_count(
    wanted: int, shape: tuple[int, ...], bands: int, per_cell: int = 4, fewest: int = 128
) -> int:
    """The ordinates asked for or, for 0, `per_cell` for each cell along the longest side.

    Then at least `fewest`. Raises InputError for fewer than 4 for each band: harmonics would alias.
    """
    if wanted == 0:
        count = max(fewest, per_cell * max(shape), 8 * bands)
        return -(-count // 4) * 4
    if wanted % 4:
        raise bad_input("ordinates", wanted, "must be a multiple of 4")
    if wanted < 4 * bands:
        rule = f"must be at least {4 * bands}, 4 for each of {bands} bands"
        raise bad_input("ordinates", wanted, rule)
    return wanted
