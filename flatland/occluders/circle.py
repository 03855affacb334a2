"""A circle in 2D."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from flatland.injectors.item import is_degenerate
from flatland.injectors.values import Broken, Point, Radius, Sides
from flatland.occluders.base import FlatOccluder


class CircleOccluder(FlatOccluder):
    """A closed round wall, as a regular polygon of n sides with the circle's circumference.

    A convex outline of the same length casts shadows of the same mean width and, in light from
    all around, receives the same flux (Cauchy's formula). Corners lie at R = r (π/n)/sin(π/n),
    outside by r (π/n)²/6; the middles of sides lie inside by r (π/n)²/3: 0.0004 r and 0.0008 r
    for 64 sides. Normals are off by up to π/n. Sides, not corners, touch the circle's extent
    along the axes, so that a circle on a wall or on the grid's border does not reach through it
    (if n is a multiple of 4).
    """

    kind: Literal["circle"] = Field("circle", description="a closed round wall")
    center: Point = Field(description="center [m]")
    radius: Radius = Field(description="radius [m]")
    # Named apart from its key, which is the name of a method of every occluder.
    sides: Sides = Field(64, alias="segments", description="number of straight walls it is made of")

    def inner_misfits(self) -> list[Broken]:
        if not any(is_degenerate(start, end) for start, end in self.outline()):
            return []
        rule = "must be larger: at this distance from [0, 0] its sides have no length"
        return [Broken(rule, key="radius", value=self.radius)]

    def outline(self) -> list[tuple[Point, Point]]:
        half = np.pi / self.sides
        angles = half * (2 * np.arange(self.sides) + 1)
        corner = self.radius * half / np.sin(half)
        vertices = np.array(self.center) + corner * np.stack([np.cos(angles), np.sin(angles)], 1)
        corners = [(float(x), float(y)) for x, y in vertices]
        return list(zip(corners, [*corners[1:], corners[0]]))
