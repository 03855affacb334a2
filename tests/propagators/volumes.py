"""Small 3D scenes for tests of the analytic reference."""

from dataclasses import dataclass, field

import numpy as np

from flatland.facets import vector_area
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.sources import Facet, ParallelSource, PointSource, PolygonSource

#: A slanted triangle and a quadrilateral that shade each other; both cross faces of cells.
LIGHTS = (
    ([(1.2, 1.1, 4.6), (4.7, 1.6, 5.1), (2.1, 4.3, 5.3)], 3.0),
    ([(4.4, 3.2, 0.7), (5.6, 3.4, 1.3), (5.5, 5.2, 1.8), (4.3, 5.0, 1.2)], 2.0),
)


@dataclass(eq=False)
class Volume:
    """What the reference reads of a scene, from lights, facets, points and beams as they are."""

    grid: Grid
    lights: list = field(default_factory=list)
    walls: list = field(default_factory=list)
    colours: int = 0
    medium: None = None

    def sources(self, part):
        assert part == "lamp"
        return self.lights

    def facets(self):
        return self.walls


def volume(shape=(6, 6, 6), lights=(), walls=(), spacing=1.0, origin=(), albedo=0.0, **more):
    """lights: (vertices, flux); walls: vertices or (vertices, albedo); all in cells.

    points: PointSource with positions in cells. beams: (direction, irradiance).
    """
    grid = Grid(shape, spacing, origin)
    sources = [PolygonSource(grid.to_world(v), np.atleast_1d(f) + 0.0) for v, f in lights]
    sources += [
        PointSource(grid.to_world(p.position), *(p.__dict__[k] for k in list(p.__dict__)[1:]))
        for p in more.get("points", ())
    ]
    sources += [
        ParallelSource(unit(way), np.atleast_1d(e) + 0.0) for way, e in more.get("beams", ())
    ]
    channels = max((len(source.spectrum) for source in sources), default=1)
    facets = []
    for wall in walls:
        vertices, own = wall if len(wall) == 2 else (wall, albedo)
        own = np.broadcast_to(np.asarray(own, float), (channels,))
        facets.append(Facet(grid.to_world(vertices), own))
    return Volume(grid, sources, facets, more.get("colours", channels if channels > 1 else 0))


def unit(vector):
    return np.asarray(vector, float) / np.linalg.norm(vector)


def point(position, flux=1.0, axis=None, series=None):
    """An isotropic point, a lobe along an axis, or a series."""
    isotropic = basis_for(3, 1).isotropic() if series is None else np.asarray(series, float)
    spectrum = np.atleast_1d(flux) + 0.0
    if axis is None:
        return PointSource(np.asarray(position, float), spectrum, isotropic)
    return PointSource(np.asarray(position, float), spectrum, 0 * isotropic, 1.0, unit(axis))


def box(low, high, albedo=0.0):
    """The six walls of a box, facing outwards."""
    faces = []
    for axis in range(3):
        for side in (0, 1):
            square = [(0, 0), (1, 0), (1, 1), (0, 1)]
            corners = np.empty((4, 3))
            corners[:, axis] = side
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = np.array(square).T
            corners = corners if side else corners[::-1]
            faces.append((np.array(low) + corners * np.subtract(high, low), albedo))
    return faces


def room(shape, albedo=0.0):
    """Walls on the border, facing inwards."""
    return [(vertices[::-1], albedo) for vertices, _ in box((0, 0, 0), shape)]


def rectangle(corner, first, second):
    """A parallelogram, its front towards first x second."""
    corner, first, second = (np.asarray(v, float) for v in (corner, first, second))
    return np.array([corner, corner + first, corner + first + second, corner + second])


def moved(vertices, x=0.0, y=0.0, z=0.0):
    return np.asarray(vertices, float) + np.array([x, y, z])


def area_of(vertices):
    return float(np.linalg.norm(vector_area(np.asarray(vertices, float))))


def cornell(size=16, colours=True):
    """A room with red, green and white walls, a light under the ceiling and two boxes.

    The front is open. The boxes stand on no grid plane.
    """
    s = size / 16
    white, red, green = ([0.73, 0.73, 0.73], [0.63, 0.06, 0.05], [0.15, 0.48, 0.09])
    walls = [[*room((size, size, size))[k]] for k in (0, 1, 2, 3, 4)]
    shades = [red, green, white, white, white]
    walls = [(vertices, shade) for (vertices, _), shade in zip(walls, shades)]
    for low, high in (((2.3, 0, 8.4), (7.1, 9.6, 13.1)), ((9.2, 0, 2.7), (13.9, 4.8, 7.4))):
        walls += [(vertices, white) for vertices, _ in box(s * np.array(low), s * np.array(high))]
    light = rectangle((6 * s, 15.9 * s, 6 * s), (4 * s, 0, 0), (0, 0, 4 * s))
    spectrum = np.array([18.0, 13.0, 8.0])
    if not colours:
        walls, spectrum = [(vertices, shade[0]) for vertices, shade in walls], 10.0
    return volume((size,) * 3, [(light, spectrum)], walls)
