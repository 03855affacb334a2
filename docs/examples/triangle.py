"""A shape of one's own: an equilateral triangle, as a module of flatland/occluders would be."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from flatland.injectors.values import Point, Radius
from flatland.occluders.base import FlatOccluder


class TriangleOccluder(FlatOccluder):
    """A closed wall with three equal sides, one corner at the top."""

    kind: Literal["triangle"] = Field("triangle", description="an equilateral triangle")
    center: Point = Field(description="center [m]")
    radius: Radius = Field(description="distance of the corners from the center [m]")

    def outline(self) -> list[tuple[Point, Point]]:
        angles = np.pi / 2 + 2 * np.pi / 3 * np.arange(3)
        vertices = np.array(self.center) + self.radius * np.stack(
            [np.cos(angles), np.sin(angles)], 1
        )
        corners = [(float(x), float(y)) for x, y in vertices]
        return list(zip(corners, [*corners[1:], corners[0]]))
