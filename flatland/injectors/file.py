"""Light from a data file (the octree thesis' file injector, section 5.1)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr

from flatland.errors import InputError, bad_input
from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Deposit, Injector
from flatland.injectors.datafile import read_coefficients
from flatland.injectors.item import rule_of
from flatland.injectors.values import Broken, FileName, PerColour
from flatland.sources import PointSource, Source


@dataclass(frozen=True, eq=False)
class Coefficients:
    """What a file held, (size, *shape), and how it compares."""

    values: Array

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Coefficients) and np.array_equal(self.values, other.values)

    __hash__ = None  # type: ignore[assignment]


class FileLight(Injector):
    """Coefficients (size, *grid shape) from an .npy file, or `coefficients` from an .npz file.

    Any number of bands: bands the run does not have are dropped, missing ones are zero. The
    file is read once, when the scene is, and nothing in it is ever executed.
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("multiplier",)

    kind: Literal["file"] = Field("file", description="coefficients from a data file")
    file: FileName = Field(description=".npy or .npz file, relative to the scene file")
    multiplier: PerColour = Field(1.0, description="factor, a number or one per colour")
    _loaded: Coefficients | None = PrivateAttr(None)

    @classmethod
    def of_values(cls, values: Array, multiplier: float | tuple[float, ...] = 1.0) -> FileLight:
        """The same from coefficients (size, *grid shape) that are in memory: no file is read."""
        light = cls.model_construct(file="memory", multiplier=multiplier)
        light._loaded = Coefficients(values)
        return light

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.multiplier

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        if self._loaded is not None and self._loaded.values.shape[1:] == grid.shape:
            return []
        try:
            self._loaded = Coefficients(read_coefficients(directory / self.file, grid))
        except InputError as error:
            return [Broken(rule_of(error), key="file", value=self.file)]
        return []

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        cells, values = self._lit(grid)
        coefficients = np.zeros((values.shape[0], basis.size))
        kept = min(basis.size, values.shape[1])
        coefficients[:, :kept] = values[:, :kept]
        return Deposit(cells, coefficients)

    def refined(self, factor: int) -> Self:
        if factor > 1:
            rule = "must be 1 for a light of kind 'file', whose coefficients belong to its cells"
            raise bad_input("resolution", factor, rule)
        return self

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        cells, values = self._lit(grid)
        spectrum = self.channels(colours)
        return [
            PointSource(position, spectrum, row)
            for position, row in zip(grid.to_world(cells.T + 0.5), values)
        ]

    def _lit(self, grid: Grid) -> tuple[NDArray[np.int64], Array]:
        """Cells (dimension, K) that hold light, and their coefficients (K, size of the file)."""
        if self._loaded is None:
            self._loaded = Coefficients(read_coefficients(Path(self.file), grid))
        values = self._loaded.values
        cells = np.stack(np.nonzero(np.any(values != 0, axis=0)))
        return cells, values[(slice(None), *cells)].T
