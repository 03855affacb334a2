"""What lights and occluders have in common: a table of a scene file that checks itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, ValidationInfo, model_validator

from flatland.errors import InputError
from flatland.grid import Grid
from flatland.injectors.values import Broken, refuse


@dataclass
class Surroundings:
    """What a table may know of its scene while the scene is being read.

    directory: where file names start. grid: None until a valid grid was read. colours: number
    of colour channels of the tables so far, 0 while all of them are grey.
    """

    directory: Path = field(default_factory=Path)
    grid: Grid | None = None
    colours: int = 0


class SceneItem(BaseModel):
    """A frozen table with a `kind`; unknown keys are refused.

    A kind declares its keys as fields, with a meaning each, so that editors and messages can be
    made from them, and the dimensions it works in.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    dimensions: ClassVar[tuple[int, ...]]
    #: Keys whose value may be a list with one number per colour.
    colour_keys: ClassVar[tuple[str, ...]]

    kind: str

    @property
    def colours(self) -> int:
        """Number of colour channels this table speaks of, 0 if it is grey."""
        return len(self._coloured[1])

    @property
    def _coloured(self) -> tuple[str, tuple[float, ...]]:
        """The first key that holds a list of colours, and the list."""
        for key in self.colour_keys:
            if isinstance(value := getattr(self, key), tuple):
                return key, value
        return "", ()

    def inner_misfits(self) -> list[Broken]:
        """Rules that the keys break among themselves."""
        return []

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        """Rules that the keys break against a grid of a supported dimension."""
        return []

    def misfits(self, around: Surroundings) -> list[Broken]:
        """All rules broken, as far as `around` lets them be checked."""
        broken = self.inner_misfits()
        if around.grid is not None:
            dimension = around.grid.dimension
            if dimension in self.dimensions:
                broken += self.grid_misfits(around.grid, around.directory)
            else:
                rule = f"exists in {shown_dimensions(self.dimensions)}, the grid is {dimension}D"
                broken.append(Broken(rule, key="kind", value=self.kind))
        if self.colours and around.colours not in (0, self.colours):
            key, value = self._coloured
            rule = f"has {self.colours} colours where the scene so far has {around.colours}"
            broken.append(Broken(rule, key=key, value=value))
        around.colours = around.colours or self.colours
        return broken

    @model_validator(mode="after")
    def _fits(self, info: ValidationInfo) -> Self:
        around = info.context if isinstance(info.context, Surroundings) else Surroundings()
        broken = self.misfits(around)
        if broken:
            raise refuse(*broken)
        return self


def shown_dimensions(dimensions: tuple[int, ...]) -> str:
    return " and ".join(f"{dimension}D" for dimension in dimensions)


def per_channel(value: float | tuple[float, ...], colours: int) -> NDArray[np.float64]:
    """A grey or coloured value as (max(1, colours),)."""
    return np.array(np.broadcast_to(np.asarray(value, float), (max(1, colours),)))


def rule_of(error: InputError) -> str:
    """The rule alone from a message "argument = value: rule"."""
    return str(error).partition(": ")[2]


def is_degenerate(start: Any, stop: Any) -> bool:
    """Whether two points (dimension,) are the same, up to rounding of their coordinates."""
    ends = np.array([start, stop], float)
    return bool(np.abs(ends[1] - ends[0]).max() <= 1e-12 * np.abs(ends).max())
