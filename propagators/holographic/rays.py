"""The rays of each level: what they meet, and how much they let through.

Level n has rays v_n(k) = (2ⁿ, 2k - 2ⁿ), k = 0 … 2ⁿ, from every lattice point on its planes
X = a 2ⁿ. Arrays hold, for plane a, row Y and ray k, the radiance of what the ray meets and its
transmittance: 0 or 1, a half where it runs on the edge of a segment, and anything between where
rays are extended.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, shared
from propagators.holographic.frames import to_world
from propagators.transport.cell_items import Items
from propagators.transport.rays import cast

Vector = NDArray[np.float64]

#: Cells. Each ray is cast on both sides of its line and counts half on each: segments often end or
#: run on lines of the lattice, and at a jump the trapezoidal rule wants the mean. Much less than
#: TOUCH of the rays, so that both start and end on the same side of what they start or end on.
BESIDE = 1e-10


@shared
def cast_rays(
    party: int, parties: int, frame: int, level: int, scale: int, nx: int, ny: int, parts: Items,
    sides: Vector, radiance: Vector, transmittance: Vector,
) -> None:  # fmt: skip
    """Exact rays, see BESIDE. scale: lattice steps per cell. sides: (2 E, C) radiance of segments.

    radiance: (planes, rows, rays, C). transmittance: (planes, rows, rays).
    """
    reach, width, height = 2**level, scale * nx, scale * ny
    planes, rows, rays = transmittance.shape
    for row in range(party, rows, parties):
        for plane in range(planes):
            x, y = to_world(frame, float(plane * reach), float(row), width, height)
            for k in range(rays):
                u, v = to_world(
                    frame, float((plane + 1) * reach), float(row + 2 * k - reach), width, height
                )
                length = math.sqrt((u - x) ** 2 + (v - y) ** 2)
                aside, along = -BESIDE * (v - y) / length, BESIDE * (u - x) / length
                transmittance[plane, row, k] = 0.0
                radiance[plane, row, k].fill(0.0)
                for sign in (-1.0, 1.0):
                    dx, dy = sign * aside, sign * along
                    hit = cast(
                        x / scale + dx, y / scale + dy, u / scale + dx, v / scale + dy, nx, ny,
                        parts,
                    )  # fmt: skip
                    if hit < 0:
                        transmittance[plane, row, k] += 0.5
                    else:
                        for colour in range(sides.shape[1]):
                            radiance[plane, row, k, colour] += 0.5 * sides[hit, colour]


@shared
def extend_rays(
    party: int, parties: int, level: int, near: Vector, open_near: Vector, radiance: Vector,
    transmittance: Vector,
) -> None:  # fmt: skip
    """Rays of level + 1 from those of `level` (near, open_near), one after the other.

    T(p, 2k) = T_n(p, k) T_n(p + v_n(k), k); T(p, 2k + 1) is the mean of the two ways round,
    k then k + 1 and k + 1 then k (Freeman, Sannikov and Margel 2025).
    """
    reach = 2**level
    planes, rows, rays = transmittance.shape
    colours = radiance.shape[3]
    for row in range(party, rows, parties):
        for plane in range(planes):
            for ray in range(rays):
                k = ray // 2
                if ray % 2 == 0:
                    _join(2 * plane, row, k, k, reach, near, open_near, 1.0, plane, ray, radiance,
                          transmittance, colours)  # fmt: skip
                else:
                    _join(2 * plane, row, k, k + 1, reach, near, open_near, 0.5, plane, ray,
                          radiance, transmittance, colours)  # fmt: skip
                    _join(2 * plane, row, k + 1, k, reach, near, open_near, 0.5, plane, ray,
                          radiance, transmittance, colours)  # fmt: skip


@inlined
def _join(
    plane: int, row: int, first: int, second: int, reach: int, near: Vector, open_near: Vector,
    share: float, to_plane: int, ray: int, radiance: Vector, transmittance: Vector, colours: int,
) -> None:  # fmt: skip
    """Adds a share of the ray `first` and, from where it ends, the ray `second`."""
    passed = open_near[plane, row, first]
    beyond, end = plane + 1, row + 2 * first - reach
    on = 0 <= end < near.shape[1] and beyond < near.shape[0]
    for colour in range(colours):
        seen = near[plane, row, first, colour]
        if on:
            seen += passed * near[beyond, end, second, colour]
        radiance[to_plane, row, ray, colour] += share * seen
    if on:
        passed *= open_near[beyond, end, second]
    transmittance[to_plane, row, ray] += share * passed
