"""A thin flat wall with four corners in 3D."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flatland.injectors.values import Broken, Quad
from flatland.occluders.base import SolidOccluder
from flatland.planar import polygon_fault


class QuadOccluder(SolidOccluder):
    """A planar wall without thickness, opaque from both sides; it need not be convex.

    Its corners may lie off one plane by flatland.planar.PLANAR of its size, and are used as they
    are, so that walls with common corners close tightly.
    """

    kind: Literal["quad"] = Field("quad", description="a thin flat wall with four corners")
    vertices: Quad = Field(description="4 points [m] in one plane, in order round the outline")

    def inner_misfits(self) -> list[Broken]:
        fault = polygon_fault(np.array(self.vertices))
        return [Broken(fault, key="vertices", value=self.vertices)] if fault else []

    def faces(self) -> list[NDArray[np.float64]]:
        return [np.array(self.vertices)]
