"""All direct light of a scene through panels: of area lights, points and parallel beams."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic_3d.geometry import Geometry
from propagators.analytic_3d.panels import Panels, panel_light
from propagators.analytic_3d.quadrature import integrate
from propagators.analytic_3d.windows import add_parallel_light, add_point_light

Array = NDArray[np.float64]


def direct_light(
    geometry: Geometry, panels: Panels, group_count: int, bands: int, tolerance: float
) -> Array:
    """Coefficients (groups, C, size) of what passes panels, summed by group.

    tolerance: relative L2 error of what area lights send; points and beams are exact.
    """
    result = np.zeros((group_count, geometry.colours, bands**2))
    if len(geometry.lights.planes):
        lights, walls = geometry.lights, geometry.walls
        result += integrate(
            panels,
            lambda some: panel_light(some, lights, geometry.radiance, walls, bands),
            lights.planes,
            group_count,
            tolerance,
        )
    add_point_light(result, geometry, panels, bands)
    add_parallel_light(result, geometry, panels, bands)
    return result
