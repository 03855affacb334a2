"""Scenes for the tests of the analytic reference."""

import numpy as np

from flatland.scene import Scene, SceneError

#: Two slanted lights, one of which shades the other, and four walls, two of which cross.
LIGHTS = (((1.2, 1.1), (3.9, 1.7), 3.0), ((6.6, 6.8), (6.1, 4.3), 2.0))
WALLS = (
    ((2.1, 3.2), (4.7, 4.1)),
    ((3.0, 4.4), (4.2, 2.9)),
    ((5.2, 0.8), (5.6, 3.3)),
    ((0.7, 5.1), (2.6, 6.9)),
)


def make_scene(shape=(8, 8), lights=LIGHTS, walls=WALLS, spacing=1.0, albedo=0.0, **more):
    """lights: (start, end, flux); walls: (start, end); both in cells, scaled by the spacing.

    albedo: of all walls. points: more lights. beams: (direction, irradiance) of parallel light.
    """
    return Scene.from_dict(
        {
            "grid": {"shape": list(shape), "spacing": spacing},
            "light": [
                {"kind": "area", "start": scaled(a, spacing), "end": scaled(b, spacing), "flux": f}
                for a, b, f in lights
            ]
            + more.get("points", [])
            + [
                {"kind": "directional", "direction": list(way), "irradiance": strength}
                for way, strength in more.get("beams", [])
            ],
            "occluder": [
                {
                    "kind": "segment",
                    "start": scaled(a, spacing),
                    "end": scaled(b, spacing),
                    "albedo": albedo,
                }
                for a, b in walls
            ],
        }
    )


def scaled(point, spacing):
    return [float(x) * spacing for x in point]


def outline(*points):
    """Walls around a polygon."""
    return list(zip(points, (*points[1:], points[0])))


def room(size=8):
    """Walls on the border."""
    return outline((0, 0), (size, 0), (size, size), (0, size))


def random_scene(seed, size=8, step=0.0, lights=2, walls=6, **more):
    """A random scene; with step > 0 all ends lie on multiples of it, so that much lines up."""
    rng = np.random.default_rng(seed)

    def segment():
        while True:
            ends = rng.uniform(0, size, (2, 2))
            ends = np.round(ends / step) * step if step else ends
            if np.any(ends[0] != ends[1]):
                return ends.tolist()

    while True:
        drawn = [(*segment(), 1.0 + k) for k in range(lights)]
        try:
            return make_scene((size, size), drawn, [segment() for _ in range(walls)], **more)
        except SceneError:  # a light that shines out of the grid
            continue
