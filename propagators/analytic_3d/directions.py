"""Directions of lines, spread evenly, and shifts of their lattices: the same in every run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

#: The plastic number: its powers give the most even additive sequence in two dimensions
#: (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
_PLASTIC = 1.324717957244746
_GOLDEN = (np.sqrt(5) - 1) / 2


class Beams(NamedTuple):
    """Directions (M, 3) whose largest component is positive, and shifts (M, 2) in [0, 1)."""

    directions: Array
    shifts: Array

    def part(self, start: int, stop: int) -> Beams:
        return Beams(self.directions[start:stop], self.shifts[start:stop])


def even_beams(count: int, seed: int) -> Beams:
    """Beams over half of all directions: a Fibonacci lattice on a hemisphere, turned at random.

    Measured against Sobol' points, of the same number of lines, it halves the error where
    directions are few.
    """
    rng = np.random.default_rng(seed)
    place = np.arange(count)
    z, azimuth = (place + 0.5) / count, 2 * np.pi * (place * _GOLDEN % 1.0)
    radius = np.sqrt(1 - z**2)
    lattice = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=-1)
    return along(Rotation.random(rng=rng).apply(lattice), rng.random(2))


def along(directions: Array, start: Array) -> Beams:
    """Beams along directions (M, 3) or, where its largest component is negative, against them."""
    largest = np.take_along_axis(directions, _largest(directions), axis=1)
    steps = np.arange(len(directions))[:, None] * [1 / _PLASTIC, 1 / _PLASTIC**2]
    return Beams(np.ascontiguousarray(directions * np.sign(largest)), (start + steps) % 1.0)


def turned(directions: Array) -> NDArray[np.bool_]:
    """Which directions (M, 3) `along` has turned round."""
    return np.asarray(np.take_along_axis(directions, _largest(directions), axis=1)[:, 0] < 0)


def _largest(directions: Array) -> NDArray[np.int64]:
    return np.argmax(np.abs(directions), axis=1)[:, None]
