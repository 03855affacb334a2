"""What a light really is, apart from any grid: the description that exact methods read.

A stencil reads a light as coefficients in cells (flatland.injection); an exact method reads the
same light as these sources. Both carry the same flux, so that they can be compared.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SegmentSource:
    """A Lambertian segment in 2D that emits to the left of start -> stop and is opaque.

    start, stop: world positions (2,) [m]. spectrum: flux per colour (colours,) [W]. Its radiance
    is flux / (2 length).
    """

    start: Vector
    stop: Vector
    spectrum: Vector


@dataclass(frozen=True, eq=False)
class PolygonSource:
    """A Lambertian planar polygon in 3D that emits to its front and is opaque.

    vertices: world positions (V, 3) [m], V ≥ 3, in one plane, counter-clockwise seen from the
    front; edges do not cross. spectrum: flux per colour (colours,) [W]. Its radiance is
    flux / (π area).
    """

    vertices: Vector
    spectrum: Vector


@dataclass(frozen=True, eq=False)
class PointSource:
    """A point that emits a given intensity and blocks nothing.

    position: (dimension,) [m]. spectrum: per colour (colours,), multiplies the intensity.
    The unit intensity is the sum of a harmonic series (`coefficients` in the basis of its own
    size) and of a Lambertian lobe of flux `lobe_flux` along the unit vector `lobe_direction`,
    kept apart because a clamped cosine has no finite series.
    """

    position: Vector
    spectrum: Vector
    coefficients: Vector
    lobe_flux: float = 0.0
    lobe_direction: Vector | None = None


@dataclass(frozen=True, eq=False)
class ParallelSource:
    """Parallel light that enters through the grid's border from outside and blocks nothing.

    direction: unit vector (dimension,) that the light travels along. spectrum: irradiance per
    colour (colours,) [W/m in 2D, W/m² in 3D] on a surface perpendicular to it. Only what is inside
    the grid shades it, walls on the grid's border included.
    """

    direction: Vector
    spectrum: Vector


Source = SegmentSource | PolygonSource | PointSource | ParallelSource


@dataclass(frozen=True, eq=False)
class Segment:
    """An opaque straight wall in 2D, from start to stop (2,) [m], seen from both sides.

    albedo: reflected share per colour, () or (colours,).
    """

    start: Vector
    stop: Vector
    albedo: Vector


@dataclass(frozen=True, eq=False)
class Facet:
    """An opaque planar polygon in 3D, seen from both sides.

    vertices: (V, 3) [m], V ≥ 3, in one plane; edges do not cross. albedo: reflected share per
    colour, () or (colours,). closed: whether it is part of a closed surface; its vertices then run
    counter-clockwise seen from outside.
    """

    vertices: Vector
    albedo: Vector
    closed: bool = False


#: What occluders are made of: segments in 2D, facets in 3D.
Wall = Segment | Facet


def segments_of(walls: Iterable[Wall]) -> list[Segment]:
    """The walls of a 2D scene."""
    return [wall for wall in walls if isinstance(wall, Segment)]


def facets_of(walls: Iterable[Wall]) -> list[Facet]:
    """The walls of a 3D scene."""
    return [wall for wall in walls if isinstance(wall, Facet)]
