"""What every occluder offers: its surface as straight or planar walls."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flatland.injectors.item import SceneItem, per_channel
from flatland.injectors.values import Share
from flatland.sources import Facet, Segment, Wall

Point = tuple[float, float]


class Occluder(SceneItem):
    """An opaque thing. It may stick out of the grid; only what is inside has an effect there."""

    colour_keys: ClassVar = ("albedo",)

    albedo: Share = Field(0.0, description="reflected share, 0 to 1, a number or one per colour")

    @abstractmethod
    def walls(self, colours: int = 0) -> Sequence[Wall]:
        """Its surface, seen from both sides, albedo (max(1, colours),)."""

    def channels(self, colours: int) -> NDArray[np.float64]:
        """The albedo (max(1, colours),); a grey one is the same in every channel."""
        return per_channel(self.albedo, colours or self.colours)


class FlatOccluder(Occluder):
    """An occluder in 2D, made of segments."""

    dimensions: ClassVar = (2,)

    @abstractmethod
    def outline(self) -> list[tuple[Point, Point]]:
        """Start and end [m] of each straight part."""

    def walls(self, colours: int = 0) -> list[Segment]:
        albedo = self.channels(colours)
        return [Segment(np.array(start), np.array(end), albedo) for start, end in self.outline()]


class SolidOccluder(Occluder):
    """An occluder in 3D, made of facets."""

    dimensions: ClassVar = (3,)

    @abstractmethod
    def faces(self) -> list[NDArray[np.float64]]:
        """Vertices (V, 3) [m] of each planar part; counter-clockwise from outside if closed."""

    @property
    def closed(self) -> bool:
        """Whether the faces close round an inside."""
        return False

    def walls(self, colours: int = 0) -> list[Facet]:
        albedo = self.channels(colours)
        return [Facet(vertices, albedo, self.closed) for vertices in self.faces()]
