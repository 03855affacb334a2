"""What every light offers: its coefficients for a grid, and what it really is."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.item import SceneItem, Surroundings, per_channel
from flatland.injectors.values import Direction
from flatland.sources import Source

Array = NDArray[np.float64]


class Deposit(NamedTuple):
    """What some cells get: indices (dimension, K), each at most once; coefficients (K, size)."""

    cells: NDArray[np.int64]
    coefficients: Array


class Injector(SceneItem):
    """A light of a scene: a spectrum times a pattern of unit flux.

    Subclasses set `dimensions` and `colour_keys` and answer `strength`, `deposit`, `sources`.
    """

    @property
    @abstractmethod
    def strength(self) -> float | tuple[float, ...]:
        """What multiplies the pattern: a flux [W] or a bare factor, grey or per colour."""

    @abstractmethod
    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        """The pattern for unit spectrum, for a grid that this light fits into."""

    @abstractmethod
    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        """The exact twin of the pattern, spectra of length max(1, colours)."""

    @property
    def spectrum(self) -> tuple[float, ...]:
        """Strength per colour; one entry if the light is grey."""
        return self.strength if isinstance(self.strength, tuple) else (self.strength,)

    def channels(self, colours: int) -> Array:
        """The spectrum (max(1, colours),); a grey light gives every channel the same."""
        return per_channel(self.strength, colours)

    def inject(self, grid: Grid, basis: AngularBasis) -> Array:
        """The pattern (size, *grid.shape) for unit spectrum [W/rad in 2D, W/sr in 3D].

        Raises InputError if the light does not fit into the grid.
        """
        for broken in self.misfits(Surroundings(Path(), grid)):
            value = broken.value if broken.key else self
            raise bad_input(broken.key or "light", value, broken.rule, broken.choices)
        require_basis(basis, grid)
        pattern = np.zeros((basis.size, *grid.shape))
        cells, coefficients = self.deposit(grid, basis)
        pattern[(slice(None), *cells)] = coefficients.T
        return pattern


def require_basis(basis: AngularBasis, grid: Grid) -> None:
    """Raise InputError if basis and grid differ in dimension."""
    if basis.dimension != grid.dimension:
        rule = f"must have the grid's {grid.dimension} dimensions"
        raise bad_input("basis", basis, rule)


def unit_vector(direction: Direction) -> Array:
    """A direction scaled to length 1."""
    vector = np.asarray(direction, float)
    vector = vector / np.abs(vector).max()  # squares of tiny components would underflow
    return np.asarray(vector / np.linalg.norm(vector))
