"""Lights: how light gets into a grid."""

from flatland.injectors.area import AreaLight
from flatland.injectors.base import Deposit, Injector
from flatland.injectors.cell import CellLight
from flatland.injectors.file import FileLight
from flatland.injectors.wall import WallLight

#: Every kind of light a scene file may name.
INJECTORS: dict[str, type[Injector]] = {
    "area": AreaLight,
    "cell": CellLight,
    "file": FileLight,
    "wall": WallLight,
}

__all__ = ["INJECTORS", "AreaLight", "CellLight", "Deposit", "FileLight", "Injector", "WallLight"]
