"""Shadow maps of a point and of the sun in the grid of `walls3d`."""

import numpy as np
from walls3d import GRID

from flatland.shadow_map import map_directional_light, map_point_light

POSITION = (7.3, 4.1, 6.2)
SUN = np.array([0.48, -0.6, -0.64])


def point_map(walls, position=POSITION, texels=64):
    return map_point_light(GRID, walls, GRID.to_world(position), texels)


def sun_map(walls, direction=SUN, texels=64):
    direction = np.array(direction, float)
    return map_directional_light(GRID, walls, direction / np.linalg.norm(direction), texels)


def received(shadow_map, walls):
    """What each wall receives of a light of unit strength."""
    return np.bincount(shadow_map.walls, shadow_map.received, len(walls))
