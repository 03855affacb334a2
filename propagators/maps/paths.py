"""Where a ray goes through the cells, and what cells send evenly along their rays."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner

Vector = NDArray[np.float64]


@inlined
def entry(wx: float, wy: float, place: float, nx: int, ny: int) -> tuple[float, float]:
    """Where a ray comes in, `place` along the side behind."""
    if abs(wx) >= abs(wy):
        return (0.0 if wx > 0.0 else float(nx)), place
    return place, (0.0 if wy > 0.0 else float(ny))


@inlined
def first_cell(x: float, w: float, size: int) -> tuple[int, float]:
    """Cell along one axis, and the distance along the ray to the first line across it."""
    i = min(max(math.floor(x), 0), size - 1)
    if w == 0.0:
        return i, math.inf
    line = i + 1 if w > 0.0 else i
    return i, (line - x) / w


@inner
def measure(wx: float, wy: float, place: float, chords: Vector) -> None:
    """chords (nx, ny) += lengths of one ray in the cells."""
    nx, ny = chords.shape[0], chords.shape[1]
    x, y = entry(wx, wy, place, nx, ny)
    i, next_x = first_cell(x, wx, nx)
    j, next_y = first_cell(y, wy, ny)
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
def spread(arc: Vector, cells: Vector, chords: Vector, gain: Vector) -> None:
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
