"""Parallel rays that march through the grid and carry flux from surface to surface.

For a direction ω with main axis a, rays enter through the side behind, at an even distance across,
and go forward row by row. One that leaves sideways comes in again on the other side of the same
row, dark: so every cell is crossed by rays at the same distance, and a ray stands for the same
flux everywhere.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner, shared
from propagators.maps.meetings import cross, fade, pass_cell
from propagators.maps.paths import entry, first_cell, measure, spread
from propagators.maps.rays import Fan, Sources, Tally
from propagators.transport.cell_items import CellItems

Vector = NDArray[np.float64]


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
                measure(wx, wy, (ray + fan.offsets[k]) / fan.rays, chords)
            spread(fan.arcs[k], sources.cells, chords, gain)
        for ray in range(across * fan.rays):
            place = (ray + fan.offsets[k]) / fan.rays
            _follow(wx, wy, place, fan.fluxes[k], fan.means[k], items, sources, gain, flux, tally)


@inner
def _follow(
    wx: float, wy: float, place: float, unit: float, mean: Vector, items: CellItems,
    sources: Sources, gain: Vector, flux: Vector, tally: Tally,
) -> None:  # fmt: skip
    """One ray, from the side behind to the side ahead. unit: its flux at radiance 1.

    What is done in every cell is written out here on plain arrays: handing over a dozen of them
    would cost ten times as much, and even three, to a function that is copied in, a tenth more.
    """
    cells, left, cell_first = tally.cells, tally.left, items.cells.first
    x_first, y_first = items.x_faces.first, items.y_faces.first
    nx, ny, size, colours = cells.shape[0], cells.shape[1], mean.size, flux.size
    deposits, gains = cells.shape[2] > 0, sources.cells.size > 0
    thick = sources.extinction > 0.0
    x, y = entry(wx, wy, place, nx, ny)
    i, next_x = first_cell(x, wx, nx)
    j, next_y = first_cell(y, wy, ny)
    step_x, step_y = (1 if wx > 0.0 else -1), (1 if wy > 0.0 else -1)
    behind_x, behind_y = (0 if wx > 0.0 else 1), (0 if wy > 0.0 else 1)
    pace_x = 1.0 / abs(wx) if wx != 0.0 else math.inf
    pace_y = 1.0 / abs(wy) if wy != 0.0 else math.inf
    main_x = abs(wx) >= abs(wy)
    flux.fill(0.0)
    if main_x:
        face = (i + behind_x) * ny + j
        if x_first[face] != x_first[face + 1]:
            cross(wx, wy, 0, face, y, unit, items.x_faces, sources, flux, tally)
    else:
        face = i * (ny + 1) + j + behind_y
        if y_first[face] != y_first[face + 1]:
            cross(wx, wy, 1, face, x, unit, items.y_faces, sources, flux, tally)
    reached = 0.0
    while True:
        over_x = next_x < next_y
        stop = next_x if over_x else next_y
        cell = i * ny + j
        if cell_first[cell] != cell_first[cell + 1]:
            pass_cell(
                wx, wy, x, y, reached, stop, i, j, unit, items.cells, sources, gain, flux, tally
            )
        elif thick:
            fade(i, j, stop - reached, sources, gain, flux, tally)
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
                cross(wx, wy, 0, face, along, unit, items.x_faces, sources, flux, tally)
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
                cross(wx, wy, 0, face, along, unit, items.x_faces, sources, flux, tally)
        else:
            face, along = i * (ny + 1) + j + 1 - behind_y, x + reached * wx
            if y_first[face] != y_first[face + 1]:
                cross(wx, wy, 1, face, along, unit, items.y_faces, sources, flux, tally)
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
                cross(wx, wy, 1, face, along, unit, items.y_faces, sources, flux, tally)
