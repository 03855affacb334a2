"""A surface of triangles from a file, in 3D."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, StrictBool

from flatland.errors import InputError, bad_input
from flatland.grid import Grid
from flatland.injectors.item import rule_of
from flatland.injectors.values import LARGEST, Broken, Factor, MeshName, SpacePoint
from flatland.occluders.base import SolidOccluder
from flatland.occluders.meshfile import read_triangles
from flatland.occluders.surfaces import SurfaceError, check_triangles, edges_of, outward

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Triangles:
    """What a file held, corners (T, 3, 3) [m], and how it compares."""

    corners: Array

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Triangles) and np.array_equal(self.corners, other.corners)

    __hash__ = None  # type: ignore[assignment]


class MeshOccluder(SolidOccluder):
    """Triangles from an .stl, .obj, .ply or .off file: the closed surface of one or more bodies.

    The file is read once, when the scene is, and only for places: a colour or texture in it has no
    effect. Corners with equal coordinates are one vertex. How triangles are wound does not matter:
    each body is turned so that they run counter-clockwise from its own outside. A surface
    with open edges is refused unless `open` says that thin walls are meant. As for a box, the
    inside is empty space.
    What it gets wrong: a polygon of more than three corners that is neither flat nor convex
    becomes a fan of triangles from its first corner.
    """

    kind: Literal["mesh"] = Field("mesh", description="a surface of triangles from a file")
    file: MeshName = Field(description=".stl, .obj, .ply or .off, relative to the scene file")
    scale: Factor = Field(1.0, description="metres per unit of the file")
    position: SpacePoint = Field((0.0, 0.0, 0.0), description="where the file's origin is [m]")
    # Named apart from its key, which is the name of a function of Python's own.
    thin: StrictBool = Field(False, alias="open", description="thin walls; need not be closed")
    _loaded: Triangles | None = PrivateAttr(None)

    @property
    def closed(self) -> bool:
        return not self.thin

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        if self._loaded is None:
            try:
                self._loaded = Triangles(self._read(directory))
            except InputError as error:
                return [Broken(rule_of(error), key="file", value=self.file)]
        return []

    def faces(self) -> list[Array]:
        if self._loaded is None:
            self._loaded = Triangles(self._read(Path()))
        return list(self._loaded.corners)

    def _read(self, directory: Path) -> Array:
        """Corners (T, 3, 3) [m]. Raises InputError."""
        triangles = read_triangles(directory / self.file)
        reach = float(np.abs(triangles).max()) * self.scale + max(map(abs, self.position))
        if not reach <= LARGEST:
            rule = f"has coordinates of {reach:.3g} m; at most {LARGEST:g} m can be read"
            raise bad_input("file", self.file, rule)
        triangles = triangles * self.scale + self.position
        edges = edges_of(triangles)
        try:
            check_triangles(triangles, edges)
            return triangles if self.thin else outward(triangles, edges)
        except SurfaceError as error:
            raise bad_input("file", self.file, str(error)) from None
