"""What a light really is, apart from any grid: the description that exact methods read.

A stencil reads a light as coefficients in cells (flatland.injection); an exact method reads the
same light as these sources. Both carry the same flux, so that they can be compared.
"""

from __future__ import annotations

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


Source = SegmentSource | PointSource | ParallelSource


@dataclass(frozen=True, eq=False)
class Segment:
    """An opaque straight wall in 2D, from start to stop (2,) [m], seen from both sides.

    albedo: reflected share per colour, () or (colours,).
    """

    start: Vector
    stop: Vector
    albedo: Vector
