"""Lights: how light gets into a grid."""

from flatland.injectors.area import AreaLight
from flatland.injectors.base import Deposit, Emission, Injector
from flatland.injectors.cell import CellLight
from flatland.injectors.directional import DirectionalLight
from flatland.injectors.environment import EnvironmentLight
from flatland.injectors.file import FileLight
from flatland.injectors.point import PointLight
from flatland.injectors.wall import WallLight

#: Every kind of light a scene file may name.
INJECTORS: dict[str, type[Injector]] = {
    "area": AreaLight,
    "cell": CellLight,
    "directional": DirectionalLight,
    "environment": EnvironmentLight,
    "file": FileLight,
    "point": PointLight,
    "wall": WallLight,
}

__all__ = [
    "INJECTORS",
    "AreaLight",
    "CellLight",
    "Deposit",
    "DirectionalLight",
    "Emission",
    "EnvironmentLight",
    "FileLight",
    "Injector",
    "PointLight",
    "WallLight",
]
