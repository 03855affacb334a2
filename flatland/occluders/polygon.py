"""A polygon in 2D."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flatland.injectors.item import is_degenerate
from flatland.injectors.values import Broken, Point, Vertices
from flatland.occluders.base import FlatOccluder


class PolygonOccluder(FlatOccluder):
    """A closed outline of walls; the last vertex is joined to the first.

    Its inside is empty space with walls around it: a light in there stays in there.
    """

    kind: Literal["polygon"] = Field("polygon", description="a closed outline of straight walls")
    vertices: Vertices = Field(description="at least 3 points [m], closed automatically")

    def inner_misfits(self) -> list[Broken]:
        count = len(self.vertices)
        repeated = [i for i, (a, b) in enumerate(self.outline(), 1) if is_degenerate(a, b)]
        if not repeated:
            return []
        first, second = repeated[0], repeated[0] % count + 1
        rule = (
            f"has the same point as vertex {first} and vertex {second}; the outline closes itself"
        )
        return [Broken(rule, key="vertices", value=self.vertices)]

    def outline(self) -> list[tuple[Point, Point]]:
        return list(zip(self.vertices, (*self.vertices[1:], self.vertices[0])))
