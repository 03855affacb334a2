"""What every lattice point sees in every cone, from the longest rays down to the shortest.

Cone i of level n lies between the rays v_n(i) and v_n(i + 1). Instead of one number a cone carries
what faces need: the integrals over it of radiance times |ω_X| y, (ω_Y)₊ y and (ω_Y)₋ y.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, shared
from propagators.holographic.frames import cell_in_world

Vector = NDArray[np.float64]


@shared
def merge_cones(
    party: int, parties: int, level: int, last: bool, near: Vector, open_near: Vector, far: Vector,
    open_far: Vector, weights: Vector, above: Vector, merged: Vector,
) -> None:  # fmt: skip
    """merged (planes, rows, 2ⁿ, C, M) of level n from `above`, that of level n + 1.

    near, open_near: rays of this level; far, open_far: of the next. weights: (2ⁿ⁺¹, M), of unit
    radiance over each cone of the next level. On odd planes a cone's half goes by the ray of this
    level that bounds it to the next plane; on even ones, which the next level has too, by the mean
    of its own cone there and of one seen past the ray of the next level, two planes on.
    last: there is no next level; nothing lies beyond its rays.
    """
    reach = 2**level
    planes, rows, cones = merged.shape[:3]
    for row in range(party, rows, parties):
        for plane in range(planes):
            for cone in range(cones):
                result = merged[plane, row, cone]
                result.fill(0.0)
                for half in range(2):
                    ray, child = cone + half, 2 * cone + half
                    weight = weights[child]
                    end = row + 2 * ray - reach
                    if last or plane % 2 == 1:
                        _add_seen(near[plane, row, ray], 1.0, weight, result)
                        if not last:
                            passed = open_near[plane, row, ray]
                            _add_beyond(above, (plane + 1) // 2, end, child, passed, result)
                    else:
                        _add_beyond(above, plane // 2, row, child, 0.5, result)
                        _add_seen(far[plane // 2, row, 2 * ray], 0.5, weight, result)
                        passed = 0.5 * open_far[plane // 2, row, 2 * ray]
                        end = row + 2 * (2 * ray - reach)
                        _add_beyond(above, plane // 2 + 1, end, child, passed, result)


@inlined
def _add_seen(radiance: Vector, share: float, weight: Vector, result: Vector) -> None:
    for colour in range(radiance.size):
        amount = share * radiance[colour]
        if amount != 0.0:
            for m in range(weight.size):
                result[colour, m] += amount * weight[m]


@inlined
def _add_beyond(
    above: Vector, plane: int, row: int, cone: int, share: float, result: Vector
) -> None:
    """Adds what a point sees in a cone of the next level; outside the lattice nothing."""
    if share == 0.0 or plane >= above.shape[0] or not 0 <= row < above.shape[1]:
        return
    for colour in range(result.shape[0]):
        for m in range(result.shape[1]):
            result[colour, m] += share * above[plane, row, cone, colour, m]


@shared
def sum_faces(
    party: int, parties: int, frame: int, scale: int, nx: int, ny: int, seen: Vector, cells: Vector
) -> None:
    """cells (nx, ny, C, size) += outflow of the light that a frame sees, by the trapezoidal rule.

    seen: (planes, rows, C, 3, size) of every lattice point. Light towards -X leaves a cell through
    its lower face in X, light towards +Y and -Y through its upper and lower face in Y.
    """
    columns = nx if frame % 2 == 0 else ny
    lines = ny if frame % 2 == 0 else nx
    colours, size = seen.shape[2], seen.shape[4]
    for i in range(party, columns, parties):
        for j in range(lines):
            wi, wj = cell_in_world(frame, i, j, nx, ny)
            for m in range(scale + 1):
                length = (0.5 if m in (0, scale) else 1.0) / scale
                for colour in range(colours):
                    ahead = seen[i * scale, j * scale + m, colour, 0]
                    up = seen[i * scale + m, (j + 1) * scale, colour, 1]
                    down = seen[i * scale + m, j * scale, colour, 2]
                    for k in range(size):
                        cells[wi, wj, colour, k] += length * (ahead[k] + up[k] + down[k])
