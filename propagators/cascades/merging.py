"""Levels of a cascade merged from the top down, and light gathered at faces and on walls."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner, shared
from propagators.cascades.face_pieces import FacePieces
from propagators.cascades.levels import Level
from propagators.transport.cell_items import Items
from propagators.transport.rays import cast

Vector = NDArray[np.float64]

VANILLA, BILINEAR_FIX, CHEAP_FIX = 0, 1, 2
#: Cells in front of a face or a wall at which light that arrives there is gathered.
INSET = 1e-6


@inner
def look(
    x: float, y: float, k: int, fix: int, nx: int, ny: int, lower: Level, upper: Level,
    above: Vector, parts: Items, radiance: Vector, result: Vector,
) -> None:  # fmt: skip
    """Radiance (b, C) at (x, y) in each child of bin k, from the lower level's interval outwards.

    b: the upper level's bins for each of the lower one's. above: (probes, R b, C), the merged
    radiance of the upper level; empty if the lower is the last. radiance: (2 E, C) of sides of
    segments. fix: what happens between the two levels' intervals. VANILLA: a ray in the lower
    interval; if it meets nothing, the 4 probes around (x, y) with bilinear weights. BILINEAR_FIX:
    from the start of the lower interval to each of these probes' start of the child's interval, so
    that nothing is skipped or seen twice. CHEAP_FIX: the same to the probe's interval in the
    parent's direction, for all children.
    """
    wx, wy = lower.directions[k, 0], lower.directions[k, 1]
    x0, y0 = x - lower.start * wx, y - lower.start * wy
    children, colours = result.shape
    last = above.shape[0] == 0
    if fix == VANILLA or last:
        hit = cast(x0, y0, x - lower.stop * wx, y - lower.stop * wy, nx, ny, parts)
        if hit >= 0 or last:
            for child in range(children):
                for colour in range(colours):
                    result[child, colour] = radiance[hit, colour] if hit >= 0 else 0.0
            return
    result.fill(0.0)
    column, row = x / upper.spacing + 0.5, y / upper.spacing + 0.5
    a = min(max(math.floor(column), 0), upper.count_x - 2)
    b = min(max(math.floor(row), 0), upper.count_y - 2)
    for corner in range(4):
        qa, qb = a + corner // 2, b + corner % 2
        weight = (1.0 - abs(column - qa)) * (1.0 - abs(row - qb))
        probe = qa * upper.count_y + qb
        qx, qy = (qa - 0.5) * upper.spacing, (qb - 0.5) * upper.spacing
        hit = -1
        if fix == CHEAP_FIX:
            hit = cast(x0, y0, qx - lower.stop * wx, qy - lower.stop * wy, nx, ny, parts)
        for child in range(children):
            bin_above = children * k + child
            if fix == BILINEAR_FIX:
                ux, uy = upper.directions[bin_above, 0], upper.directions[bin_above, 1]
                hit = cast(x0, y0, qx - lower.stop * ux, qy - lower.stop * uy, nx, ny, parts)
            for colour in range(colours):
                seen = radiance[hit, colour] if hit >= 0 else above[probe, bin_above, colour]
                result[child, colour] += weight * seen


@shared
def merge_level(
    party: int, parties: int, fix: int, nx: int, ny: int, branching: int, lower: Level,
    upper: Level, above: Vector, parts: Items, radiance: Vector, merged: Vector,
) -> None:  # fmt: skip
    """merged (probes, R, C) of the lower level: what each probe sees from its interval outwards."""
    seen = np.empty((branching, radiance.shape[1]))
    for probe in range(party, merged.shape[0], parties):
        x = (probe // lower.count_y - 0.5) * lower.spacing
        y = (probe % lower.count_y - 0.5) * lower.spacing
        for k in range(merged.shape[1]):
            look(x, y, k, fix, nx, ny, lower, upper, above, parts, radiance, seen)
            for colour in range(seen.shape[1]):
                merged[probe, k, colour] = seen[:, colour].sum() / branching


@shared
def gather_cells(
    party: int, parties: int, fix: int, nx: int, ny: int, lower: Level, upper: Level,
    above: Vector, parts: Items, radiance: Vector, faces: FacePieces,
    nodes: Vector, weights: Vector, tables: Vector, cells: Vector, left: Vector,
) -> None:  # fmt: skip
    """cells (nx, ny, C, size) of what leaves through the four faces, left (C,) over the border.

    nodes, weights: Gauss rule on [0, 1]. tables: (4, R, size), ∫ max(0, n·ω) y dω over the bins,
    for the faces in -x, +x, -y, +y.
    """
    seen = np.empty((1, radiance.shape[1]))
    for cell in range(party, nx * ny, parties):
        i, j = cell // ny, cell % ny
        for side in range(4):
            ahead = side % 2
            if side < 2:
                face, pieces = (i + ahead) * ny + j, faces.x_faces
                outside = i + ahead == 0 or i + ahead == nx
            else:
                face, pieces = i * (ny + 1) + j + ahead, faces.y_faces
                outside = j + ahead == 0 or j + ahead == ny
            inset = (1 - 2 * ahead) * INSET
            for piece in range(pieces.first[face], pieces.first[face + 1]):
                low, high = pieces.ends[piece, 0], pieces.ends[piece, 1]
                leaves = outside and not pieces.covered[piece]
                for node in range(nodes.size):
                    place = low + nodes[node] * (high - low)
                    x = i + ahead + inset if side < 2 else place
                    y = place if side < 2 else j + ahead + inset
                    length = weights[node] * (high - low)
                    for k in range(lower.directions.shape[0]):
                        if (lower.directions[k, side // 2] > 0.0) != (ahead == 1):
                            continue
                        look(x, y, k, fix, nx, ny, lower, upper, above, parts, radiance, seen)
                        _add(seen[0], length, tables[side, k], leaves, cells[i, j], left)


@inlined
def _add(
    seen: Vector, length: float, table: Vector, leaves: bool, cell: Vector, left: Vector
) -> None:
    """cell (C, size) += length times radiance times the table; the flux also to left."""
    for colour in range(seen.size):
        amount = length * seen[colour]
        if amount != 0.0:
            for m in range(table.size):
                cell[colour, m] += amount * table[m]
            if leaves:
                # The constant harmonic is 1/√(2π).
                left[colour] += amount * table[0] * math.sqrt(2.0 * math.pi)


@shared
def gather_sides(
    party: int, parties: int, fix: int, nx: int, ny: int, lower: Level, upper: Level,
    above: Vector, parts: Items, radiance: Vector, segments: Vector,
    nodes: Vector, weights: Vector, arrived: Vector,
) -> None:  # fmt: skip
    """arrived (2 E, C): flux on the left and the right of segments (E, 4)."""
    seen, count = np.empty((1, radiance.shape[1])), lower.directions.shape[0]
    width = 2.0 * math.pi / count
    for side in range(party, arrived.shape[0], parties):
        segment = segments[side // 2]
        ex, ey = segment[2] - segment[0], segment[3] - segment[1]
        length = math.sqrt(ex * ex + ey * ey)
        sign = 1.0 if side % 2 == 0 else -1.0
        across, along = -sign * ey / length, sign * ex / length
        # Light arrives against the normal.
        inward = math.atan2(-along, -across)
        for node in range(nodes.size):
            x = segment[0] + nodes[node] * ex + INSET * across
            y = segment[1] + nodes[node] * ey + INSET * along
            if not (0.0 <= x <= nx and 0.0 <= y <= ny):
                continue
            for k in range(count):
                start = k * width - inward
                flux = weights[node] * length * _positive_cosine(start, start + width)
                if flux <= 0.0:
                    continue
                look(x, y, k, fix, nx, ny, lower, upper, above, parts, radiance, seen)
                for colour in range(seen.shape[1]):
                    arrived[side, colour] += flux * seen[0, colour]


@inlined
def _positive_cosine(a: float, b: float) -> float:
    """∫ max(0, cos θ) dθ from a to b."""
    return _primitive(b) - _primitive(a)


@inlined
def _primitive(a: float) -> float:
    turns = math.floor(a / (2.0 * math.pi) + 0.5)
    rest = a - 2.0 * math.pi * turns
    return 2.0 * turns + math.sin(min(max(rest, -0.5 * math.pi), 0.5 * math.pi))
