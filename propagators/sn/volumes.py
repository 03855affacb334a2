"""Finite-volume sweeps: each cell turns mean radiances on two faces into those on the other two.

In the quadrant of ω, with c = |ω_x| and s = |ω_y|, light enters through the faces W and S and
leaves through E and N. All three rules conserve c L_E + s L_N = c L_W + s L_S.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner, shared
from propagators.sn.cut_cells import CutCell, cross_cut_cell, make_cut_cell
from propagators.transport.cell_items import CellItems, Items

Vector = NDArray[np.float64]

STEP, DIAMOND, STEP_CHARACTERISTICS = 0, 1, 2


class Tally(NamedTuple):
    """What a sweep leaves behind. cells: (nx, ny, C * size). arrived: (E, 2, C). left: (C,)."""

    cells: Vector
    arrived: Vector
    left: Vector


@shared
def cross_empty_cell(
    rule: int, c: float, s: float, west: float, south: float
) -> tuple[float, float]:
    """Mean radiances on the faces E and N.

    Step: both are the cell's mean. Diamond: the mean of opposite faces is the cell's mean; a
    negative one is set to 0 and the other gets all the flux. Step characteristics: radiance is
    constant on W and on S, and what leaves is its exact mean on E and on N.
    """
    if rule == STEP:
        mean = (c * west + s * south) / (c + s)
        return mean, mean
    if rule == DIAMOND:
        mean = (c * west + s * south) / (c + s)
        east, north = 2.0 * mean - west, 2.0 * mean - south
        if east < 0.0:
            return 0.0, (c * west + s * south) / s
        if north < 0.0:
            return (c * west + s * south) / c, 0.0
        return east, north
    if s <= c:
        return ((c - s) * west + s * south) / c, west
    return south, ((s - c) * south + c * west) / s


@shared
def sweep_volumes(
    rule: int,
    directions: Vector,
    harmonics: Vector,
    weight: float,
    items: CellItems,
    blocks: NDArray[np.bool_],
    radiance: Vector,
    tally: Tally,
) -> None:
    """Adds the ordinates `directions` (K, 2) to the tally.

    harmonics: (K, size), times the weight [rad]. blocks: (E,), which segments stop light. radiance:
    (E, 2, C) of their left and right side.
    """
    work = make_cut_cell(items.cells, radiance.shape[2])
    for k in range(directions.shape[0]):
        _sweep(
            rule, directions[k, 0], directions[k, 1], harmonics[k], weight, items, blocks,
            radiance, tally, work,
        )  # fmt: skip


@inner
def _sweep(
    rule: int,
    wx: float,
    wy: float,
    harmonics: Vector,
    weight: float,
    items: CellItems,
    blocks: NDArray[np.bool_],
    radiance: Vector,
    tally: Tally,
    work: CutCell,
) -> None:
    nx, ny, colours = tally.cells.shape[0], tally.cells.shape[1], radiance.shape[2]
    c, s = abs(wx), abs(wy)
    right, up = (1 if wx > 0.0 else 0), (1 if wy > 0.0 else 0)
    south, west = np.zeros((nx, colours)), np.zeros(colours)
    for row in range(ny):
        j = row if up else ny - 1 - row
        west.fill(0.0)
        for column in range(nx):
            i = column if right else nx - 1 - column
            below = south[i]
            place = i * (ny + 1) + j + 1 - up
            _pass_face(wx, wy, 1, place, items.y_faces, blocks, radiance, weight, below, tally)
            place = (i + 1 - right) * ny + j
            _pass_face(wx, wy, 0, place, items.x_faces, blocks, radiance, weight, west, tally)
            # From here on `west` and `below` become what leaves through E and N.
            cell = i * ny + j
            if items.cells.first[cell] != items.cells.first[cell + 1]:
                cross_cut_cell(
                    wx, wy, i, j, cell, items.cells, blocks, radiance, weight, west, below,
                    tally.arrived, work,
                )  # fmt: skip
            else:
                for colour in range(colours):
                    if west[colour] != 0.0 or below[colour] != 0.0:
                        west[colour], below[colour] = cross_empty_cell(
                            rule, c, s, west[colour], below[colour]
                        )
            _add_outflow(c, s, west, below, harmonics, tally.cells[i, j])
        _leave(wx, wy, 0, right * nx * ny + j, items.x_faces, blocks, radiance, weight, west, tally)
    for i in range(nx):
        place = i * (ny + 1) + up * ny
        _leave(wx, wy, 1, place, items.y_faces, blocks, radiance, weight, south[i], tally)


@inlined
def _add_outflow(
    c: float, s: float, east: Vector, north: Vector, harmonics: Vector, cell: Vector
) -> None:
    """cell (C * size,) += I y, I = c L_E + s L_N."""
    size = harmonics.size
    for colour in range(east.size):
        intensity = c * east[colour] + s * north[colour]
        if intensity != 0.0:
            for k in range(size):
                cell[colour * size + k] += intensity * harmonics[k]


@inlined
def _leave(
    wx: float, wy: float, axis: int, place: int, faces: Items, blocks: NDArray[np.bool_],
    radiance: Vector, weight: float, face: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Past what lies on the border, and out."""
    _pass_face(wx, wy, axis, place, faces, blocks, radiance, weight, face, tally)
    for colour in range(face.size):
        tally.left[colour] += weight * abs(wx if axis == 0 else wy) * face[colour]


@inlined
def _pass_face(
    wx: float, wy: float, axis: int, place: int, faces: Items, blocks: NDArray[np.bool_],
    radiance: Vector, weight: float, face: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Light of mean radiance `face` (C,), changed, passes what lies on a face."""
    if faces.first[place] == faces.first[place + 1]:
        return
    slope = abs(wx if axis == 0 else wy)
    for colour in range(face.size):
        arriving, stopped, added = face[colour], 0.0, 0.0
        for k in range(faces.first[place], faces.first[place + 1]):
            e, part = faces.segments[k], faces.ends[k]
            share = abs(part[3 - axis] - part[1 - axis])
            ahead = 0 if (part[2] - part[0]) * wy - (part[3] - part[1]) * wx > 0.0 else 1
            if blocks[e]:
                stopped += share
                tally.arrived[e, 1 - ahead, colour] += weight * slope * share * arriving
            added += share * radiance[e, ahead, colour]
        face[colour] = arriving * (1.0 - stopped) + added
