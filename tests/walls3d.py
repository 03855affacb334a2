"""Facets in a grid, what rays meet of them, by brute force, and their shadow maps."""

import numpy as np

from flatland.grid import Grid
from flatland.shadow_map import map_directional_light, map_point_light
from flatland.sources import Facet

GRID = Grid((16, 12, 10), 0.5, (1.0, -2.0, 3.0))

#: Polygons in cells: a slanted quad, two triangles that cross, an L on a cell border, a wall that
#: sticks out of the grid.
SLANTED = ((2.0, 2.0, 1.0), (10.0, 3.0, 1.0), (10.0, 9.0, 3.0), (2.0, 8.0, 3.0))
CROSSING = (
    ((5.0, 1.0, 2.0), (6.4, 8.0, 3.0), (6.0, 5.0, 8.0)),
    ((3.0, 6.0, 2.5), (8.0, 5.0, 2.5), (5.0, 4.0, 7.0)),
)
L_SHAPE = ((9, 0, 9), (16, 0, 9), (16, 5, 9), (12, 5, 9), (12, 9, 9), (9, 9, 9))
STICKS_OUT = ((12.0, -9.0, -3.0), (14.5, 20.0, -3.0), (14.5, 20.0, 14.0), (12.0, -9.0, 14.0))
POLYGONS = (SLANTED, *CROSSING, L_SHAPE, STICKS_OUT)
#: Where a lamp is, in cells, and the way of parallel light.
POSITION = (7.3, 4.1, 6.2)
SUN = np.array([0.48, -0.6, -0.64])


def facet(vertices, albedo=0.5, grid=GRID):
    """A facet from vertices in cells."""
    return Facet(grid.to_world(np.array(vertices, float)), np.array(albedo, float))


def facets(polygons=POLYGONS, albedo=0.5, grid=GRID):
    return [facet(polygon, albedo, grid) for polygon in polygons]


def normal_of(vertices):
    """Unit normal (3,) of a polygon without repeated vertices, of either sign."""
    arms = np.array(vertices, float) - vertices[0]
    vector = np.cross(arms[1:-1], arms[2:]).sum(axis=0)
    return vector / np.linalg.norm(vector)


def inside_polygon(points, vertices):
    """Which points (K, 2) a loop (V, 2) runs round, by counting crossings."""
    inside = np.zeros(len(points), bool)
    for a, b in zip(vertices, np.roll(vertices, -1, axis=0)):
        if a[1] != b[1]:
            spans = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
            x = a[0] + (points[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            inside ^= spans & (points[:, 0] < x)
    return inside


def first_hits(origins, directions, polygons, shape=GRID.shape):
    """Which polygon each ray meets first in the grid, or -1, and the distance; all in cells."""
    best, owner = np.full(len(directions), 1e9), np.full(len(directions), -1)
    for number, polygon in enumerate(polygons):
        vertices = np.array(polygon, float)
        normal = normal_of(vertices)
        slope = directions @ normal
        slope = np.where(np.abs(slope) < 1e-12, 1e-12, slope)
        distance = ((vertices[0] - origins) @ normal) / slope
        points = origins + distance[:, None] * directions
        flat = [k for k in range(3) if k != np.argmax(np.abs(normal))]
        inside = inside_polygon(points[:, flat], vertices[:, flat])
        inside &= np.all((points >= -1e-9) & (points <= np.array(shape) + 1e-9), axis=1)
        # Where walls lie on one another the first listed counts, as in the map.
        hit = inside & (distance > 0) & (distance < best * (1 - 1e-9))
        best[hit], owner[hit] = distance[hit], number
    return owner, best


def random_polygon(rng, snapped):
    """A star round a point, or an L along the axes on cell borders."""
    centre = rng.uniform((0, 0, 0), GRID.shape)
    normal = np.eye(3)[rng.integers(3)] if snapped else rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    frame = np.stack(
        [first / np.linalg.norm(first), np.cross(normal, first / np.linalg.norm(first))]
    )
    if snapped:
        corners = np.array([(-2, -3), (3, -3), (3, 1), (0, 1), (0, 4), (-2, 4)], float)
        return np.round(centre) + np.round(corners @ frame)
    angles = np.linspace(0, 2 * np.pi, rng.integers(3, 8), endpoint=False)
    angles += rng.uniform(0, 0.5, len(angles))
    radius = rng.uniform(1, 6, len(angles))
    circle = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    return centre + circle @ frame


def point_map(walls, position=POSITION, texels=64):
    return map_point_light(GRID, walls, GRID.to_world(position), texels)


def sun_map(walls, direction=SUN, texels=64):
    direction = np.array(direction, float)
    return map_directional_light(GRID, walls, direction / np.linalg.norm(direction), texels)
