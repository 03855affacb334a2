"""Parallel rays that march through the grid and carry flux from surface to surface.

For a direction ω with main axis a, rays enter through the side behind, at an even distance across,
and go forward row by row. One that leaves sideways comes in again on the other side of the same
row, dark: so every cell is crossed by rays at the same distance, and a ray stands for the same
flux everywhere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner, shared
from propagators.transport.cell_items import CellItems, Items

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells along a ray; what lies within this of a part that was just met is that part.
TOUCH = 1e-12
#: Of a part's length, so that no ray slips through between two parts that share an end.
_SLACK = 1e-12


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
    """

    radiance: Vector
    blocks: NDArray[np.bool_]
    cells: Vector


class Tally(NamedTuple):
    """What rays leave behind. cells: (nx, ny, C * size), without lanes not looked at.

    arrived: (E, 2, C). passed: (E, 2), flux of radiance 1 that rays could carry away from each
    side. left: (C,).
    """

    cells: Vector
    arrived: Vector
    passed: Vector
    left: Vector


@shared
def march(
    party: int, parties: int, fan: Fan, items: CellItems, sources: Sources, tally: Tally
) -> None:
    """Adds all rays of the fan's directions party, party + parties, … to the tally."""
    nx, ny, colours = tally.cells.shape[0], tally.cells.shape[1], sources.radiance.shape[2]
    flux, gain, chords = np.empty(colours), np.zeros((nx, ny, colours)), np.zeros((nx, ny))
    for k in range(party, fan.directions.shape[0], parties):
        wx, wy = fan.directions[k, 0], fan.directions[k, 1]
        across = ny if abs(wx) >= abs(wy) else nx
        if sources.cells.size > 0:
            chords.fill(0.0)
            for ray in range(across * fan.rays):
                _measure(wx, wy, (ray + fan.offsets[k]) / fan.rays, chords)
            _spread(fan.arcs[k], sources.cells, chords, gain)
        for ray in range(across * fan.rays):
            place = (ray + fan.offsets[k]) / fan.rays
            _follow(wx, wy, place, fan.fluxes[k], fan.means[k], items, sources, gain, flux, tally)


@inlined
def _entry(wx: float, wy: float, place: float, nx: int, ny: int) -> tuple[float, float]:
    """Where a ray comes in, `place` along the side behind."""
    if abs(wx) >= abs(wy):
        return (0.0 if wx > 0.0 else float(nx)), place
    return place, (0.0 if wy > 0.0 else float(ny))


@inlined
def _first_cell(x: float, w: float, size: int) -> tuple[int, float]:
    """Cell along one axis, and the distance along the ray to the first line across it."""
    i = min(max(math.floor(x), 0), size - 1)
    if w == 0.0:
        return i, math.inf
    line = i + 1 if w > 0.0 else i
    return i, (line - x) / w


@inner
def _follow(
    wx: float, wy: float, place: float, unit: float, mean: Vector, items: CellItems,
    sources: Sources, gain: Vector, flux: Vector, tally: Tally,
) -> None:  # fmt: skip
    """One ray, from the side behind to the side ahead. unit: its flux at radiance 1.

    What is done in every cell is written out here on plain arrays: handing over a dozen of them
    would cost ten times as much.
    """
    cells, left, cell_first = tally.cells, tally.left, items.cells.first
    x_first, y_first = items.x_faces.first, items.y_faces.first
    nx, ny, size, colours = cells.shape[0], cells.shape[1], mean.size, flux.size
    deposits, gains = cells.shape[2] > 0, sources.cells.size > 0
    x, y = _entry(wx, wy, place, nx, ny)
    i, next_x = _first_cell(x, wx, nx)
    j, next_y = _first_cell(y, wy, ny)
    step_x, step_y = (1 if wx > 0.0 else -1), (1 if wy > 0.0 else -1)
    behind_x, behind_y = (0 if wx > 0.0 else 1), (0 if wy > 0.0 else 1)
    pace_x = 1.0 / abs(wx) if wx != 0.0 else math.inf
    pace_y = 1.0 / abs(wy) if wy != 0.0 else math.inf
    main_x = abs(wx) >= abs(wy)
    flux.fill(0.0)
    if main_x:
        face = (i + behind_x) * ny + j
        if x_first[face] != x_first[face + 1]:
            _cross(wx, wy, 0, face, y, unit, items.x_faces, sources, flux, tally)
    else:
        face = i * (ny + 1) + j + behind_y
        if y_first[face] != y_first[face + 1]:
            _cross(wx, wy, 1, face, x, unit, items.y_faces, sources, flux, tally)
    reached = 0.0
    while True:
        over_x = next_x < next_y
        stop = next_x if over_x else next_y
        cell = i * ny + j
        if cell_first[cell] != cell_first[cell + 1]:
            _pass_cell(
                wx, wy, x, y, reached, stop, i, j, unit, items.cells, sources, gain, flux, tally
            )
        elif gains:
            for colour in range(colours):
                flux[colour] += (stop - reached) * gain[i, j, colour]
        if deposits:
            for colour in range(colours):
                amount = flux[colour]
                if amount != 0.0:
                    for k in range(size):
                        cells[i, j, colour * size + k] += amount * mean[k]
        reached = stop
        if over_x:
            face, along = (i + 1 - behind_x) * ny + j, y + reached * wy
            if x_first[face] != x_first[face + 1]:
                _cross(wx, wy, 0, face, along, unit, items.x_faces, sources, flux, tally)
            i += step_x
            next_x += pace_x
            if 0 <= i < nx:
                continue
            for colour in range(colours):
                left[colour] += flux[colour]
                flux[colour] = 0.0
            if main_x:
                return
            x -= step_x * nx
            i -= step_x * nx
            face = (i + behind_x) * ny + j
            if x_first[face] != x_first[face + 1]:
                _cross(wx, wy, 0, face, along, unit, items.x_faces, sources, flux, tally)
        else:
            face, along = i * (ny + 1) + j + 1 - behind_y, x + reached * wx
            if y_first[face] != y_first[face + 1]:
                _cross(wx, wy, 1, face, along, unit, items.y_faces, sources, flux, tally)
            j += step_y
            next_y += pace_y
            if 0 <= j < ny:
                continue
            for colour in range(colours):
                left[colour] += flux[colour]
                flux[colour] = 0.0
            if not main_x:
                return
            y -= step_y * ny
            j -= step_y * ny
            face = i * (ny + 1) + j + behind_y
            if y_first[face] != y_first[face + 1]:
                _cross(wx, wy, 1, face, along, unit, items.y_faces, sources, flux, tally)


@inner
def _cross(
    wx: float, wy: float, axis: int, face: int, along: float, unit: float, faces: Items,
    sources: Sources, flux: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Past what lies on a face, at the place `along` it.

    Light that arrives there has left its cell before; what starts there has not left the cell
    behind.
    """
    for k in range(faces.first[face], faces.first[face + 1]):
        low, high = faces.ends[k, 1 - axis], faces.ends[k, 3 - axis]
        if min(low, high) <= along < max(low, high):
            _meet(wx, wy, unit, k, faces, sources, flux, tally)


@inner
def _pass_cell(
    wx: float, wy: float, x: float, y: float, start: float, stop: float, i: int, j: int,
    unit: float, cells: Items, sources: Sources, gain: Vector, flux: Vector, tally: Tally,
) -> None:  # fmt: skip
    """Through one cell, past what lies in it."""
    cell = i * tally.cells.shape[1] + j
    first, last = cells.first[cell], cells.first[cell + 1]
    reached = start
    while first < last:
        nearest, part = stop + TOUCH, -1
        for k in range(first, last):
            way = _distance(wx, wy, x, y, cells.ends[k])
            if reached + TOUCH < way < nearest:
                nearest, part = way, k
        if part < 0:
            break
        _gain(i, j, nearest - reached, sources, gain, flux)
        _meet(wx, wy, unit, part, cells, sources, flux, tally)
        reached = nearest
    _gain(i, j, stop - reached, sources, gain, flux)


@inlined
def _meet(
    wx: float, wy: float, unit: float, part: int, items: Items, sources: Sources, flux: Vector,
    tally: Tally,
) -> None:  # fmt: skip
    """A part of a segment takes the flux and sends its own."""
    e = items.segments[part]
    if not sources.blocks[e]:
        return
    ends = items.ends[part]
    ahead = 0 if (ends[2] - ends[0]) * wy - (ends[3] - ends[1]) * wx > 0.0 else 1
    tally.passed[e, ahead] += unit
    for colour in range(flux.size):
        tally.arrived[e, 1 - ahead, colour] += flux[colour]
        flux[colour] = unit * sources.radiance[e, ahead, colour]


@inlined
def _distance(wx: float, wy: float, x: float, y: float, part: Vector) -> float:
    """How far along the ray from (x, y) a part lies; infinite if it is not met."""
    ex, ey = part[2] - part[0], part[3] - part[1]
    across = wx * ey - wy * ex
    if across == 0.0:
        return math.inf
    ox, oy = part[0] - x, part[1] - y
    share = (ox * wy - oy * wx) / across
    if share < -_SLACK or share > 1.0 + _SLACK:
        return math.inf
    return (ox * ey - oy * ex) / across


@inlined
def _gain(i: int, j: int, length: float, sources: Sources, gain: Vector, flux: Vector) -> None:
    """What a cell sends along a chord."""
    if sources.cells.size > 0 and length > 0.0:
        for colour in range(flux.size):
            flux[colour] += length * gain[i, j, colour]


@inner
def _measure(wx: float, wy: float, place: float, chords: Vector) -> None:
    """chords (nx, ny) += lengths of one ray in the cells."""
    nx, ny = chords.shape[0], chords.shape[1]
    x, y = _entry(wx, wy, place, nx, ny)
    i, next_x = _first_cell(x, wx, nx)
    j, next_y = _first_cell(y, wy, ny)
    main_x, reached = abs(wx) >= abs(wy), 0.0
    while True:
        over_x = next_x < next_y
        stop = next_x if over_x else next_y
        chords[i, j] += stop - reached
        reached = stop
        if over_x:
            i += 1 if wx > 0.0 else -1
            next_x += 1.0 / abs(wx)
            if main_x and (i < 0 or i >= nx):
                return
            i %= nx
        else:
            j += 1 if wy > 0.0 else -1
            next_y += 1.0 / abs(wy)
            if not main_x and (j < 0 or j >= ny):
                return
            j %= ny


@inlined
def _spread(arc: Vector, cells: Vector, chords: Vector, gain: Vector) -> None:
    """gain (nx, ny, C): flux per length of ray that cells send into a bin."""
    size = arc.size
    for i in range(chords.shape[0]):
        for j in range(chords.shape[1]):
            for colour in range(gain.shape[2]):
                total = 0.0
                for k in range(size):
                    total += arc[k] * cells[i, j, colour * size + k]
                # A cell that no ray crosses sends nothing: it takes one ray a cell, in a corner.
                gain[i, j, colour] = total / chords[i, j] if chords[i, j] > 0.0 else 0.0
