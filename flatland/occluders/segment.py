"""A thin straight wall in 2D."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flatland.injectors.item import is_degenerate
from flatland.injectors.values import Broken, Point
from flatland.occluders.base import FlatOccluder


class SegmentOccluder(FlatOccluder):
    """A wall without thickness from start to end, opaque from both sides."""

    kind: Literal["segment"] = Field("segment", description="a thin straight wall")
    start: Point = Field(description="start [m]")
    end: Point = Field(description="end [m]")

    def inner_misfits(self) -> list[Broken]:
        if not is_degenerate(self.start, self.end):
            return []
        rule = "must differ from start: a segment needs a length"
        return [Broken(rule, key="end", value=self.end)]

    def outline(self) -> list[tuple[Point, Point]]:
        return [(self.start, self.end)]
