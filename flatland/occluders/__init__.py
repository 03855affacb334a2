"""Occluders: what stands in the way of light."""

from flatland.occluders.base import Occluder
from flatland.occluders.box import BoxOccluder
from flatland.occluders.circle import CircleOccluder
from flatland.occluders.mesh import MeshOccluder
from flatland.occluders.polygon import PolygonOccluder
from flatland.occluders.quad import QuadOccluder
from flatland.occluders.segment import SegmentOccluder

#: Every kind of occluder a scene file may name.
OCCLUDERS: dict[str, type[Occluder]] = {
    "box": BoxOccluder,
    "circle": CircleOccluder,
    "mesh": MeshOccluder,
    "polygon": PolygonOccluder,
    "quad": QuadOccluder,
    "segment": SegmentOccluder,
}

__all__ = [
    "OCCLUDERS",
    "BoxOccluder",
    "CircleOccluder",
    "MeshOccluder",
    "Occluder",
    "PolygonOccluder",
    "QuadOccluder",
    "SegmentOccluder",
]
