"""What lines carry: which sides of elements see one another, and light through cells."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.threads import run_shared
from propagators.analytic.compiling import inner, parties_for, share_work, shared
from propagators.analytic_3d.elements import Rasters
from propagators.analytic_3d.lines import Hits, Lattice, find_hits, make_lattice
from propagators.analytic_3d.plates import TOUCH

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]


def seen_pairs(
    directions: Vector, shifts: Vector, density: float, sheets: Rasters, shape: tuple[int, ...]
) -> tuple[Indices, Indices, Indices]:
    """Sides that lines connect: (K,) the one that faces along, the one that faces against, and
    which direction. -1 stands for the open: a line that meets no further wall."""
    cells = np.array(shape, np.int64)
    found: list[Indices] = []

    def trace(party: int, parties: int) -> None:
        found.append(_pairs(party, parties, directions, shifts, density, sheets, cells))

    run_shared(trace, parties_for(len(directions) * 64))
    pairs = np.concatenate(found, axis=1)
    return pairs[0], pairs[1], pairs[2]


@shared
def _pairs(
    party: int,
    parties: int,
    directions: Vector,
    shifts: Vector,
    density: float,
    sheets: Rasters,
    shape: Indices,
) -> Indices:
    pairs, count = np.empty((3, 4096), np.int64), 0
    for m in range(party, directions.shape[0], parties):
        hits = find_hits(make_lattice(directions[m], shifts[m], density, shape), sheets)
        for line in range(hits.heads.size):
            here, side = hits.heads[line], -1
            while here >= 0:
                if count + 2 > pairs.shape[1]:
                    wider = np.empty((3, 2 * count + 2), np.int64)
                    wider[:, :count] = pairs[:, :count]
                    pairs = wider
                pairs[0, count], pairs[1, count], pairs[2, count] = side, hits.against[here], m
                side, here = hits.along[here], hits.following[here]
                count += 1
            if side >= 0:
                pairs[0, count], pairs[1, count], pairs[2, count] = side, -1, m
                count += 1
    return pairs[:, :count].copy()


def carried_light(
    directions: Vector,
    shifts: Vector,
    density: float,
    sheets: Rasters,
    radiance: Vector,
    shape: tuple[int, ...],
) -> Vector:
    """Intensity (M, nx ny nz, 2 C + 1) of what sides of radiance (sides, C) send through cells.

    C columns of light that travels along the directions (M, 3), C of light against them, and what
    the first would be if all radiance were 1. Every line stands for the cross-section of a cell of
    its lattice, and counts in each cell that it leaves.
    """
    result = np.zeros((len(directions), math.prod(shape), 2 * radiance.shape[1] + 1))
    cells = np.array(shape, np.int64)
    share_work(
        _carry, len(directions) * 64, directions, shifts, density, sheets, radiance, cells, result
    )
    return result


@shared
def _carry(
    party: int,
    parties: int,
    directions: Vector,
    shifts: Vector,
    density: float,
    sheets: Rasters,
    radiance: Vector,
    shape: Indices,
    result: Vector,
) -> None:
    for m in range(party, directions.shape[0], parties):
        lattice = make_lattice(directions[m], shifts[m], density, shape)
        hits = find_hits(lattice, sheets)
        area = lattice.step**2 * directions[m, lattice.c]
        for i in range(lattice.count_u):
            u = (lattice.first_u + i) * lattice.step
            for j in range(lattice.count_v):
                v = (lattice.first_v + j) * lattice.step
                head = hits.heads[i * lattice.count_v + j]
                _march(u, v, head, lattice, hits, radiance, shape, result[m])
        result[m] *= area


@inner
def _march(
    u: float,
    v: float,
    head: int,
    lattice: Lattice,
    hits: Hits,
    radiance: Vector,
    shape: Indices,
    result: Vector,
) -> None:
    """Adds one line's light to the cells (nx ny nz, ...) that it passes, from face to face.

    Light that arrives at a face on which a wall lies counts, light that starts there does not:
    along the line, walls count from beyond a face on, against it until before.
    """
    a, b, c = lattice.a, lattice.b, lattice.c
    z, stop = _range_in(u, v, lattice, shape)
    if stop - z <= TOUCH:
        return
    stride_a, stride_b, stride_c = _stride(a, shape), _stride(b, shape), _stride(c, shape)
    cell_a = _cell(u + z * lattice.slope_a, shape[a])
    cell_b = _cell(v + z * lattice.slope_b, shape[b])
    cell_c = _cell(z, shape[c])
    cell = cell_a * stride_a + cell_b * stride_b + cell_c * stride_c
    exit_a, wait_a, left_a = _exits(u, lattice.slope_a, cell_a, shape[a])
    exit_b, wait_b, left_b = _exits(v, lattice.slope_b, cell_b, shape[b])
    exit_c, wait_c, left_c = _exits(0.0, 1.0, cell_c, shape[c])
    stride_a = stride_a if lattice.slope_a > 0.0 else -stride_a
    stride_b = stride_b if lattice.slope_b > 0.0 else -stride_b
    colours = radiance.shape[1]
    last, behind, ahead = -1, head, head
    while ahead >= 0 and hits.heights[ahead] <= z + TOUCH:
        ahead = hits.following[ahead]
    while True:
        here = result[cell]
        if ahead >= 0:
            side = hits.against[ahead]
            for colour in range(colours):
                here[colours + colour] += radiance[side, colour]
        z = min(exit_a, exit_b, exit_c)
        while behind >= 0 and hits.heights[behind] < z - TOUCH:
            last, behind = behind, hits.following[behind]
        while ahead >= 0 and hits.heights[ahead] <= z + TOUCH:
            ahead = hits.following[ahead]
        if last >= 0:
            side = hits.along[last]
            for colour in range(colours):
                here[colour] += radiance[side, colour]
        here[2 * colours] += 1.0
        if z == exit_c:
            exit_c, left_c, cell = exit_c + wait_c, left_c - 1, cell + stride_c
        elif z == exit_a:
            exit_a, left_a, cell = exit_a + wait_a, left_a - 1, cell + stride_a
        else:
            exit_b, left_b, cell = exit_b + wait_b, left_b - 1, cell + stride_b
        if min(left_a, left_b, left_c) <= 0:
            return


@inner
def _range_in(u: float, v: float, lattice: Lattice, shape: Indices) -> tuple[float, float]:
    """Where a line is in the grid, from z to z."""
    low, high = 0.0, float(shape[lattice.c])
    for start, slope, size in (
        (u, lattice.slope_a, shape[lattice.a]),
        (v, lattice.slope_b, shape[lattice.b]),
    ):
        if slope == 0.0:
            if not 0.0 <= start <= size:
                return 0.0, 0.0
            continue
        a, b = -start / slope, (size - start) / slope
        low, high = max(low, min(a, b)), min(high, max(a, b))
    return low, high


@inner
def _stride(axis: int, shape: Indices) -> int:
    """Cells between neighbours along an axis."""
    return (shape[1] * shape[2], shape[2], 1)[axis]


@inner
def _cell(place: float, size: int) -> int:
    return min(max(math.floor(place), 0), size - 1)


@inner
def _exits(start: float, slope: float, cell: int, size: int) -> tuple[float, float, int]:
    """Where a line leaves its cell along one axis, how far apart exits are, how many there are."""
    if slope > 0.0:
        return (cell + 1 - start) / slope, 1.0 / slope, size - cell
    if slope < 0.0:
        return (cell - start) / slope, -1.0 / slope, cell + 1
    return math.inf, math.inf, size
