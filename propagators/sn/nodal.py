"""Short characteristics on the nodes of the grid: radiance at cell corners, interpolated upstream.

The radiance at a corner is that at the point where the ray through it enters the cell upstream, on
the line between two corners already known, unless a segment lies in between (Kunasz and Auer 1988,
with linear interpolation). Nothing keeps the flux: it is read off afterwards.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner, shared
from propagators.sn.volumes import Tally
from propagators.transport.cell_items import CellItems, Items

Vector = NDArray[np.float64]

#: Of a cell; a segment this near to the end of a ray is met by it, or left behind, as a face is.
TOUCH = 1e-9


@shared
def sweep_nodes(
    directions: Vector,
    harmonics: Vector,
    weight: float,
    items: CellItems,
    blocks: NDArray[np.bool_],
    radiance: Vector,
    tally: Tally,
) -> None:
    """Adds the ordinates `directions` (K, 2) to the tally; arguments as in `sweep_volumes`."""
    nx, ny, colours = tally.cells.shape[0], tally.cells.shape[1], radiance.shape[2]
    nodes = np.zeros((nx + 1, ny + 1, colours))
    for k in range(directions.shape[0]):
        wx, wy = directions[k, 0], directions[k, 1]
        _fill_nodes(wx, wy, items, blocks, radiance, nodes)
        _read_cells(wx, wy, harmonics[k], weight, items, blocks, nodes, tally)
        _read_segments(wx, wy, weight, items, blocks, radiance, nodes, tally)


@inlined
def _fill_nodes(
    wx: float, wy: float, items: CellItems, blocks: NDArray[np.bool_], radiance: Vector,
    nodes: Vector,
) -> None:  # fmt: skip
    nx, ny = nodes.shape[0] - 1, nodes.shape[1] - 1
    right, up = (1 if wx > 0.0 else -1), (1 if wy > 0.0 else -1)
    nodes[0 if right > 0 else nx].fill(0.0)
    nodes[:, 0 if up > 0 else ny].fill(0.0)
    for row in range(1, ny + 1):
        j = row if up > 0 else ny - row
        for column in range(1, nx + 1):
            i = column if right > 0 else nx - column
            _trace_back(wx, wy, float(i), float(j), items, blocks, radiance, nodes, nodes[i, j])


@inlined
def _read_cells(
    wx: float, wy: float, harmonics: Vector, weight: float, items: CellItems,
    blocks: NDArray[np.bool_], nodes: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Outflow of each cell: a face's mean radiance is that of its two corners."""
    c, s, size = abs(wx), abs(wy), harmonics.size
    right, up = (1 if wx > 0.0 else 0), (1 if wy > 0.0 else 0)
    nx, ny = tally.cells.shape[0], tally.cells.shape[1]
    for i in range(nx):
        for j in range(ny):
            out_east, out_north = 0.0, 0.0
            if i == right * (nx - 1):
                out_east = _open_share(items.x_faces, (i + right) * ny + j, blocks)
            if j == up * (ny - 1):
                out_north = _open_share(items.y_faces, i * (ny + 1) + j + up, blocks)
            for colour in range(nodes.shape[2]):
                east = 0.5 * (nodes[i + right, j, colour] + nodes[i + right, j + 1, colour])
                north = 0.5 * (nodes[i, j + up, colour] + nodes[i + 1, j + up, colour])
                intensity = c * east + s * north
                if intensity != 0.0:
                    for k in range(size):
                        tally.cells[i, j, colour * size + k] += intensity * harmonics[k]
                tally.left[colour] += weight * (c * east * out_east + s * north * out_north)


@inlined
def _open_share(faces: Items, place: int, blocks: NDArray[np.bool_]) -> float:
    """Of a face, what no wall lies on."""
    share = 1.0
    for k in range(faces.first[place], faces.first[place + 1]):
        if blocks[faces.segments[k]]:
            part = faces.ends[k]
            share -= abs(part[2] - part[0]) + abs(part[3] - part[1])
    return share


@inlined
def _read_segments(
    wx: float, wy: float, weight: float, items: CellItems, blocks: NDArray[np.bool_],
    radiance: Vector, nodes: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Flux on what blocks: the radiance at the middle of each part."""
    arriving = np.empty(radiance.shape[2])
    for faces in (items.cells, items.x_faces, items.y_faces):
        for k in range(faces.segments.size):
            e, part = faces.segments[k], faces.ends[k]
            if not blocks[e]:
                continue
            turn = (part[2] - part[0]) * wy - (part[3] - part[1]) * wx
            ahead = 0 if turn > 0.0 else 1
            x, y = 0.5 * (part[0] + part[2]), 0.5 * (part[1] + part[3])
            _trace_back(wx, wy, x, y, items, blocks, radiance, nodes, arriving)
            for colour in range(arriving.size):
                tally.arrived[e, 1 - ahead, colour] += weight * abs(turn) * arriving[colour]


@inner
def _trace_back(
    wx: float, wy: float, x: float, y: float, items: CellItems, blocks: NDArray[np.bool_],
    radiance: Vector, nodes: Vector, result: Vector,
) -> None:  # fmt: skip
    """Radiance (C,) of light that arrives at (x, y) along ω, from where it entered the cell."""
    nx, ny = nodes.shape[0] - 1, nodes.shape[1] - 1
    i = math.ceil(x - TOUCH) - 1 if wx > 0.0 else math.floor(x + TOUCH)
    j = math.ceil(y - TOUCH) - 1 if wy > 0.0 else math.floor(y + TOUCH)
    if i < 0 or i >= nx or j < 0 or j >= ny:
        result.fill(0.0)
        return
    west, south = (i if wx > 0.0 else i + 1), (j if wy > 0.0 else j + 1)
    to_west, to_south = (x - west) / wx, (y - south) / wy
    if to_west <= to_south:
        back, u, v = to_west, float(west), y - to_west * wy
        share = min(max(v - j, 0.0), 1.0)
        for colour in range(result.size):
            low, high = nodes[west, j, colour], nodes[west, j + 1, colour]
            result[colour] = low + share * (high - low)
        faces, place = items.x_faces, west * ny + j
    else:
        back, u, v = to_south, x - to_south * wx, float(south)
        share = min(max(u - i, 0.0), 1.0)
        for colour in range(result.size):
            low, high = nodes[i, south, colour], nodes[i + 1, south, colour]
            result[colour] = low + share * (high - low)
        faces, place = items.y_faces, i * (ny + 1) + south
    _pass(wx, wy, u, v, back, faces, place, blocks, radiance, result)
    _pass(wx, wy, u, v, back, items.cells, i * ny + j, blocks, radiance, result)


@inner
def _pass(
    wx: float, wy: float, u: float, v: float, reach: float, faces: Items, place: int,
    blocks: NDArray[np.bool_], radiance: Vector, result: Vector,
) -> None:  # fmt: skip
    """What a ray from (u, v) meets before `reach`: the last that blocks, and lights beyond it."""
    last, blocker = -1.0, -1
    for k in range(faces.first[place], faces.first[place + 1]):
        if blocks[faces.segments[k]]:
            way = _distance(wx, wy, u, v, faces.ends[k])
            if last < way < reach - TOUCH:
                last, blocker = way, k
    if blocker >= 0:
        e, ahead = faces.segments[blocker], _ahead(wx, wy, faces.ends[blocker])
        for colour in range(result.size):
            result[colour] = radiance[e, ahead, colour]
    for k in range(faces.first[place], faces.first[place + 1]):
        e = faces.segments[k]
        if not blocks[e] and last < _distance(wx, wy, u, v, faces.ends[k]) < reach - TOUCH:
            ahead = _ahead(wx, wy, faces.ends[k])
            for colour in range(result.size):
                result[colour] += radiance[e, ahead, colour]


@inlined
def _distance(wx: float, wy: float, u: float, v: float, part: Vector) -> float:
    """How far along the ray from (u, v) a part of a segment lies; infinite if it is not met."""
    ex, ey = part[2] - part[0], part[3] - part[1]
    across = wx * ey - wy * ex
    if across == 0.0:
        return math.inf
    way = ((part[0] - u) * ey - (part[1] - v) * ex) / across
    share = ((part[0] - u) * wy - (part[1] - v) * wx) / across
    return max(way, 0.0) if way > -TOUCH and 0.0 <= share <= 1.0 else math.inf


@inlined
def _ahead(wx: float, wy: float, part: Vector) -> int:
    """Side that faces along ω."""
    return 0 if (part[2] - part[0]) * wy - (part[3] - part[1]) * wx > 0.0 else 1
