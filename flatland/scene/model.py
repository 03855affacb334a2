"""A scene: grid, lights and occluders, checked as a whole."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Self, Union

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetPydanticSchema,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from flatland.errors import InputError
from flatland.grid import Grid
from flatland.injectors import INJECTORS, Injector
from flatland.injectors.base import Part
from flatland.injectors.item import SceneItem, Surroundings, rule_of
from flatland.injectors.values import Broken, Origin, Shape, Spacing, Text, refuse
from flatland.medium import Medium
from flatland.memory import require_memory
from flatland.occluders import OCCLUDERS, Occluder
from flatland.scene.medium_table import MediumTable
from flatland.scene.problems import SceneError, problems_in, scene_error
from flatland.shadow_map import LightBudget
from flatland.sources import Facet, Segment, Source, Wall, facets_of, segments_of

#: What the leanest run holds: source, target and accumulated field, one band, float32.
BYTES_PER_CELL = 3 * 4


def _one_of(registry: Mapping[str, type[BaseModel]]) -> GetPydanticSchema:
    """Validation as the kind that a table names."""
    kinds: Any = Annotated[Union[tuple(registry.values())], Field(discriminator="kind")]  # noqa: UP007
    return GetPydanticSchema(lambda _, handler: handler.generate_schema(kinds))


class GridTable(BaseModel):
    """The [grid] table."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    shape: Shape = Field(description="number of cells along x, y[, z]")
    spacing: Spacing = Field(1.0, description="side of a cell [m]")
    origin: Origin = Field((), description="position of the lower corner [m]; zero without it")

    @property
    def grid(self) -> Grid:
        return Grid(self.shape, self.spacing, self.origin)

    @model_validator(mode="after")
    def _fits(self, info: ValidationInfo) -> Self:
        broken = too_large(self.shape)
        if self.origin and len(self.origin) != len(self.shape):
            rule = f"must be {len(self.shape)} numbers, as shape"
            broken.append(Broken(rule, key="origin", value=self.origin))
        if broken:
            raise refuse(*broken)
        if isinstance(info.context, Surroundings):
            info.context.grid = self.grid
        return self


class Scene(BaseModel):
    """What is there, apart from how it is computed (product: methods are no part of a scene).

    Make one with `Scene.from_dict`, `parse_scene` or `load_scene`: they report every mistake at
    once, as one SceneError, and check lights against the grid. Scenes are values: frozen, equal
    if their contents are.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: Text = Field("", description="one line that says what the scene shows")
    grid_table: GridTable = Field(alias="grid", description="cells and where they are")
    lights: tuple[Annotated[Injector, _one_of(INJECTORS)], ...] = Field(
        (), alias="light", description="lights, one table each"
    )
    occluders: tuple[Annotated[Occluder, _one_of(OCCLUDERS)], ...] = Field(
        (), alias="occluder", description="occluders, one table each"
    )
    medium_table: MediumTable = Field(
        MediumTable(), alias="medium", description="what fills the grid; a vacuum without it"
    )

    @classmethod
    def from_dict(
        cls, data: Mapping[str, Any], source: str = "scene", directory: str | os.PathLike[str] = ""
    ) -> Self:
        """A scene from the same tables and keys as a file: {"grid": {...}, "light": [{...}]}.

        NumPy arrays and numbers, and values of these classes, may stand for lists and tables.
        source: what error messages call the scene. directory: where data files are looked up.
        Raises SceneError.
        """
        try:
            return cls.model_validate(_plain(data), context=Surroundings(Path(directory)))
        except RecursionError:
            raise scene_error(data, "is nested too deeply", source) from None
        except ValidationError as error:
            raise SceneError(problems_in(error, cls, source)) from None

    @property
    def grid(self) -> Grid:
        return self.grid_table.grid

    @property
    def medium(self) -> Medium | None:
        """What fills the grid; None for a vacuum."""
        return self.medium_table.medium

    @property
    def colours(self) -> int:
        """Number of colour channels; 0 if every light and albedo is a single number."""
        return max((item.colours for item in (*self.lights, *self.occluders)), default=0)

    def sources(self, part: Part = "both") -> list[Source]:
        """What the lights really are; spectra of length max(1, colours).

        The exact twins of what a stencil gets, or the "direct" or "bounce" part of it. "lamp": all
        that shines by itself, whatever a light's `inject` says: where a method that follows every
        bounce itself starts.
        """
        walls = self.walls()
        grid, colours = self.grid, self.colours
        return [
            source for light in self.lights for source in light.twins(grid, walls, colours, part)
        ]

    def budgets(self) -> list[LightBudget | None]:
        """Per light, where its flux goes before it is reflected; None for kinds without a map."""
        walls = self.walls()
        return [light.budget(self.grid, walls, self.colours) for light in self.lights]

    def walls(self) -> list[Wall]:
        """The walls of all occluders; albedo (max(1, colours),)."""
        colours = self.colours
        return [wall for occluder in self.occluders for wall in occluder.walls(colours)]

    def segments(self) -> list[Segment]:
        """The walls of a 2D scene."""
        return segments_of(self.walls())

    def facets(self) -> list[Facet]:
        """The walls of a 3D scene."""
        return facets_of(self.walls())

    def to_dict(self) -> dict[str, Any]:
        """Tables and keys as in a file, without what equals its default; from_dict reverses it."""
        tables: dict[str, Any] = {"title": self.title} if self.title else {}
        tables["grid"] = {"shape": self.grid_table.shape, **_changed(self.grid_table)}
        items: tuple[SceneItem, ...]
        for key, items in (("light", self.lights), ("occluder", self.occluders)):
            if items:
                tables[key] = [{"kind": item.kind, **_changed(item)} for item in items]
        if filling := _changed(self.medium_table):
            tables["medium"] = filling
        return tables

    @model_validator(mode="after")
    def _lights_are_clear_of_walls(self) -> Self:
        walls = self.walls() if any(light.bounces for light in self.lights) else []
        broken = [
            replace(rule, key=f"light, {number}, {rule.key}")
            for number, light in enumerate(self.lights, 1)
            for rule in light.wall_misfits(self.grid, walls)
        ]
        if broken:
            raise refuse(*broken)
        return self

    @model_validator(mode="after")
    def _colours_fit(self) -> Self:
        broken = too_large(self.grid_table.shape, max(1, self.colours))
        if broken:
            raise refuse(Broken(broken[0].rule, key="grid, shape", value=self.grid_table.shape))
        return self


def too_large(shape: tuple[int, ...], colours: int = 1) -> list[Broken]:
    """The broken rule of a grid that the leanest run would not fit into memory."""
    cells = int(np.prod(np.array(shape, dtype=object)))
    try:
        require_memory(cells * colours * BYTES_PER_CELL, "shape", shape)
    except InputError as error:
        return [Broken(rule_of(error), key="shape", value=shape)]
    return []


def _changed(table: BaseModel) -> dict[str, Any]:
    """Keys of a table that differ from their default."""
    return table.model_dump(exclude_defaults=True, by_alias=True)


def _plain(value: Any) -> Any:
    """NumPy arrays and numbers, models and mappings as lists, numbers and dicts."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Grid):
        return {"shape": value.shape, "spacing": value.spacing, "origin": value.origin}
    if isinstance(value, BaseModel):
        return _plain({"kind": getattr(value, "kind", None), **_changed(value)})
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items() if entry is not None}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value
