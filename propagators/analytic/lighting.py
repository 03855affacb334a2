"""All light of a scene on targets: of segments, points, parallel beams and reflecting walls."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.geometry import Geometry
from propagators.analytic.parallel import collect_parallel_light
from propagators.analytic.points import collect_point_light
from propagators.analytic.targets import collect_light
from propagators.watching import Progress, nobody

Array = NDArray[np.float64]


class Reflected(Protocol):
    """Light that walls send back, see `radiosity`."""

    def arriving(self, groups: Array, walls: Array, bands: int, report: Progress) -> Array: ...


def collect_all(
    geometry: Geometry,
    groups: Array,
    bands: int,
    reflected: Reflected | None = None,
    report: Progress = nobody,
) -> Array:
    """Moments (G, C, 2 bands - 1) of what arrives on groups of targets (G, P, 4).

    Without `reflected`, only what comes from the lights directly. report: gets the share done.
    """
    walls = geometry.walls
    moments = collect_light(groups, geometry.emitters, geometry.radiance, walls, bands)
    if len(geometry.positions):
        points = geometry.positions, geometry.series, geometry.lobes, geometry.spectra
        moments += collect_point_light(groups, *points, walls, bands)
    if len(geometry.directions):
        beams = geometry.directions, geometry.irradiances
        moments += collect_parallel_light(groups, *beams, walls[~geometry.gates], bands)
    if reflected is not None:
        moments += reflected.arriving(groups, walls, bands, report)
    return moments
