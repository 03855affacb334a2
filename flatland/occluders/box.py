"""A box in 3D."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flatland.injectors.item import is_degenerate
from flatland.injectors.values import Broken, SpacePoint
from flatland.occluders.base import SolidOccluder

#: Corners of the unit cube, counter-clockwise from outside, of the lower and upper face of x.
_FACES_OF_X = (
    ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)),
    ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
)


class BoxOccluder(SolidOccluder):
    """Six walls along the axes. Its inside is empty space: a light in there stays in there."""

    kind: Literal["box"] = Field("box", description="six walls along the axes")
    # Named apart from their keys, which are names of Python's own.
    lower: SpacePoint = Field(alias="min", description="lower corner [m]")
    upper: SpacePoint = Field(alias="max", description="upper corner [m]")

    closed: ClassVar = True

    def inner_misfits(self) -> list[Broken]:
        pairs = zip("xyz", self.lower, self.upper)
        flat = [axis for axis, low, high in pairs if low >= high or is_degenerate([low], [high])]
        if not flat:
            return []
        rule = f"must be greater than min along {', '.join(flat)}: a box needs an inside"
        return [Broken(rule, key="max", value=self.upper)]

    def faces(self) -> list[NDArray[np.float64]]:
        ends = np.array([self.lower, self.upper])
        corners = np.array(_FACES_OF_X)
        turned = [np.roll(face, axis, axis=1) for axis in range(3) for face in corners]
        return [ends[face, np.arange(3)] for face in turned]
