"""What every occluder offers: its outline as straight walls."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from pydantic import Field

from flatland.injectors.item import SceneItem, per_channel
from flatland.injectors.values import Share
from flatland.sources import Segment

Point = tuple[float, float]


class Occluder(SceneItem):
    """An opaque thing. It may stick out of the grid; only what is inside has an effect there."""

    colour_keys: ClassVar = ("albedo",)

    albedo: Share = Field(0.0, description="reflected share, 0 to 1, a number or one per colour")

    @abstractmethod
    def outline(self) -> list[tuple[Point, Point]]:
        """Start and end [m] of each straight part."""

    def segments(self, colours: int = 0) -> list[Segment]:
        """The outline as walls seen from both sides, albedo (max(1, colours),)."""
        albedo = per_channel(self.albedo, colours or self.colours)
        return [Segment(np.array(start), np.array(end), albedo) for start, end in self.outline()]
