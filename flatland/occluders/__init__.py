"""Occluders: what stands in the way of light."""

from flatland.occluders.base import Occluder
from flatland.occluders.box import BoxOccluder
from flatland.occluders.circle import CircleOccluder
from flatland.occluders.polygon import PolygonOccluder
from flatland.occluders.segment import SegmentOccluder

#: Every kind of occluder a scene file may name.
OCCLUDERS: dict[str, type[Occluder]] = {
    "box": BoxOccluder,
    "circle": CircleOccluder,
    "polygon": PolygonOccluder,
    "segment": SegmentOccluder,
}

__all__ = [
    "OCCLUDERS",
    "BoxOccluder",
    "CircleOccluder",
    "Occluder",
    "PolygonOccluder",
    "SegmentOccluder",
]
