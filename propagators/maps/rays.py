"""What rays stand for, where they get their light, and what they leave behind."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class Fan(NamedTuple):
    """Directions and what a ray of each stands for.

    directions: (K, 2). offsets: (K,), where the first ray enters, in ray distances. fluxes: (K,),
    of a ray of radiance 1. means: (K, size), y averaged over the bin, weighted by the cosine to the
    main axis: coefficients of a ray of flux 1. arcs: (K, size), ∫ y dω over the bin. rays: for each
    cell across.
    """

    directions: Vector
    offsets: Vector
    fluxes: Vector
    means: Vector
    arcs: Vector
    rays: int


class Sources(NamedTuple):
    """What shines.

    radiance: (E, 2, C), of left and right side of segments. blocks: (E,), which of them stop light.
    cells: (nx, ny, C * size), coefficients of what cells send, spread over them; empty without any.
    extinction: collisions per cell length, 0 in a vacuum.
    """

    radiance: Vector
    blocks: NDArray[np.bool_]
    cells: Vector
    extinction: float


class Tally(NamedTuple):
    """What rays leave behind. cells: (nx, ny, C * size), without lanes not looked at.

    arrived: (E, 2, C). passed: (E, 2), flux of radiance 1 that rays could carry away from each
    side. left: (C,). collided: (nx, ny, C), with the medium.
    """

    cells: Vector
    arrived: Vector
    passed: Vector
    left: Vector
    collided: Vector
