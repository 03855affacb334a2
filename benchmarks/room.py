"""A coloured room with a light under the ceiling and two boxes, for the reference in 3D."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.sources import Facet, PolygonSource

Array = NDArray[np.float64]

WHITE, RED, GREEN = ((0.73, 0.73, 0.73), (0.63, 0.06, 0.05), (0.15, 0.48, 0.09))


@dataclass(eq=False)
class Room:
    """What the reference reads of a scene. Open in front, all lengths in cells."""

    grid: Grid
    lights: list[PolygonSource]
    walls: list[Facet]
    colours: int = 3

    def sources(self, part: str) -> list[PolygonSource]:
        return self.lights

    def facets(self) -> list[Facet]:
        return self.walls


def make_room(size: int = 16) -> Room:
    """The room in size³ cells; the boxes lie on no grid plane but the floor."""
    unit = size / 16
    walls = [
        Facet(corners[::-1], np.array(albedo))
        for corners, albedo in zip(_sides((0, 0, 0), (16, 16, 16)), (RED, GREEN, *3 * [WHITE]))
    ]
    for low, high in (((2.3, 0, 8.4), (7.1, 9.6, 13.1)), ((9.2, 0, 2.7), (13.9, 4.8, 7.4))):
        walls += [Facet(corners, np.array(WHITE), closed=True) for corners in _sides(low, high)]
    lamp = np.array([(6, 15.9, 6), (10, 15.9, 6), (10, 15.9, 10), (6, 15.9, 10)])
    light = PolygonSource(unit * lamp, np.array([18.0, 13.0, 8.0]))
    scaled = [Facet(unit * wall.vertices, wall.albedo, wall.closed) for wall in walls]
    return Room(Grid((size, size, size)), [light], scaled)


def _sides(low: tuple[float, ...], high: tuple[float, ...]) -> list[Array]:
    """The sides of a box, lower and upper along each axis, counter-clockwise from outside."""
    ends, sides = np.array([low, high], float), []
    for axis, upper in itertools.product(range(3), (0, 1)):
        across, along = (axis + 1) % 3, (axis + 2) % 3
        corners = np.empty((4, 3))
        corners[:, axis] = ends[upper, axis]
        corners[:, across] = ends[[0, 1, 1, 0], across]
        corners[:, along] = ends[[0, 0, 1, 1], along]
        sides.append(corners if upper else corners[::-1])
    return sides
