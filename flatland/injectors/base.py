"""What every light offers: its coefficients for a grid, and what it really is."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.item import SceneItem, Surroundings, per_channel
from flatland.injectors.values import Broken, Direction
from flatland.shadow_map import LightBudget
from flatland.sources import Source, Wall

Array = NDArray[np.float64]

#: Of what a light injects: what it sends itself, what the first surfaces it meets send back, or
#: both. "lamp": what it sends itself, injected or not.
Part = Literal["both", "direct", "bounce", "lamp"]


class Deposit(NamedTuple):
    """What some cells get: indices (dimension, K), each at most once; coefficients (K, size)."""

    cells: NDArray[np.int64]
    coefficients: Array


class Emission(NamedTuple):
    """Light of one spectrum (max(1, colours),), and what one unit of it puts into cells."""

    spectrum: Array
    deposit: Deposit


class Injector(SceneItem):
    """A light of a scene: a spectrum times a pattern of unit flux.

    Subclasses set `dimensions` and `colour_keys` and answer `strength`, `deposit`, `sources`.
    Those whose light depends on the scene's walls answer `emissions` and `twins` too.
    """

    #: Whether the light casts a shadow map, so that its first bounce off walls is known.
    bounces: ClassVar[bool] = False

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

    def emissions(
        self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall] = (), colours: int = 0
    ) -> list[Emission]:
        """All that this light puts into cells among walls, one entry per spectrum."""
        return [Emission(self.channels(colours), self.deposit(grid, basis))]

    def twins(
        self,
        grid: Grid,
        walls: Sequence[Wall] = (),
        colours: int = 0,
        part: Part = "both",
    ) -> list[Source]:
        """The exact twins of `emissions`, of all of them or of a part."""
        return [] if part == "bounce" else self.sources(grid, colours)

    def wall_misfits(self, grid: Grid, walls: Sequence[Wall]) -> list[Broken]:
        """Rules that the keys break against the scene's walls; asked of lights that bounce."""
        return []

    def refined(self, factor: int) -> Self:
        """The same light on cells `factor` times as small; kinds that count in cells answer this.

        Raises InputError where that light does not exist.
        """
        return self

    def budget(self, grid: Grid, walls: Sequence[Wall], colours: int = 0) -> LightBudget | None:
        """Where the light goes before it is reflected; None where nothing but a solver knows."""
        return None

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


def collect(cells: NDArray[np.int64], coefficients: Array, shape: tuple[int, ...]) -> Deposit:
    """One deposit from cells (dimension, K) in any order, repeated or not, and (K, size)."""
    flat = np.ravel_multi_index(tuple(cells), shape)
    unique, place = np.unique(flat, return_inverse=True)
    sums = np.zeros((unique.size, coefficients.shape[1]))
    np.add.at(sums, place, coefficients)
    return Deposit(np.stack(np.unravel_index(unique, shape)), sums)


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
