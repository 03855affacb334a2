"""Shadow maps of meshes in 3D."""

from __future__ import annotations

import numpy as np
import trimesh
from conftest import best_seconds

from flatland.grid import Grid
from flatland.shadow_map import map_directional_light, map_point_light
from flatland.sources import Facet

GRID = Grid((32, 32, 32))


def test_map_of_ten_thousand_triangles(report):
    mesh = trimesh.creation.torus(8.0, 3.0, major_sections=100, minor_sections=50)
    walls = [Facet(t, np.array(0.5), True) for t in mesh.triangles + np.array([16, 12, 16])]
    position, direction = np.array([16.2, 26.3, 15.9]), np.array([0.48, -0.8, 0.36])
    seconds = {}
    for texels in (64, 256):
        point = best_seconds(lambda n=texels: map_point_light(GRID, walls, position, n), 3)
        sun = best_seconds(lambda n=texels: map_directional_light(GRID, walls, direction, n), 3)
        seconds[texels] = (point, sun)
    report(
        "shadow map of 10,000 triangles, point and directional: "
        + ", ".join(f"{n} texels {p:.2f} s and {s:.2f} s" for n, (p, s) in seconds.items())
    )
    assert max(seconds[256]) < 5.0
