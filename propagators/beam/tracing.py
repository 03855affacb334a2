"""What one beam of light leaves in the cells that it crosses: exact, and without visiting them all.

A beam is a convex quadrilateral: between two rays along ω, from a near edge, which sends the light,
to a far edge, which stops it. The part of a grid line inside it is a stretch, the chord. A chord
from y₀ to y₁ on the line x = i adds c (min(y₁, j+1) - max(y₀, j)) to every cell j that the light
leaves there. That is the running sum of two numbers at each of its ends; so a chord costs the same
however long it is, and the sums are made once, after the last beam. A last lane counts chords, in
whole numbers: where it sums to zero no light has come, and what rounding left is cleared.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.beams import EDGE_ON
from propagators.analytic.compiling import inlined, shared

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Of a cell; a chord that reaches less far into it does not light it.
SLIVER = 1e-12


@inlined
def trace(
    wx: float,
    wy: float,
    p0: float,
    p1: float,
    near0: float,
    near1: float,
    far0: float,
    far1: float,
    near_lines: Counts,
    far_lines: Counts,
    amount: Vector,
    dx: Vector,
    dy: Vector,
) -> None:
    """Adds a beam to the ends of runs: dx (nx, ny + 2, lanes) along y, dy (ny, nx + 2, lanes).

    p0 < p1: places across of the two rays; near, far: places along where each begins and ends.
    near_lines, far_lines: grid lines x and y that the edges lie on, or -1: light that starts on a
    face does not leave the cell behind, light that stops on a face has left the cell before it.
    amount: (lanes - 1,), radiance per unit across.
    """
    nx, ny = dx.shape[0], dy.shape[0]
    reach = max(_exit(wx, wy, p0, nx, ny), _exit(wx, wy, p1, nx, ny))
    end0, end1 = min(far0, reach), min(far1, reach)
    if abs(wx) > EDGE_ON:
        low = min(min(near0 * wx - p0 * wy, near1 * wx - p1 * wy), end0 * wx - p0 * wy)
        high = max(max(near0 * wx - p0 * wy, near1 * wx - p1 * wy), end0 * wx - p0 * wy)
        low, high = min(low, end1 * wx - p1 * wy), max(high, end1 * wx - p1 * wy)
        _lines(
            wx, wy, p0, p1, near0, near1, far0, far1, low, high, near_lines[0], far_lines[0],
            ny, amount, dx,
        )  # fmt: skip
    if abs(wy) > EDGE_ON:
        low = min(min(near0 * wy + p0 * wx, near1 * wy + p1 * wx), end0 * wy + p0 * wx)
        high = max(max(near0 * wy + p0 * wx, near1 * wy + p1 * wx), end0 * wy + p0 * wx)
        low, high = min(low, end1 * wy + p1 * wx), max(high, end1 * wy + p1 * wx)
        # Mirrored in the diagonal: x and y change places, and across changes its sign.
        _lines(
            wy, wx, -p1, -p0, near1, near0, far1, far0, low, high, near_lines[1], far_lines[1],
            nx, amount, dy,
        )  # fmt: skip


@inlined
def _exit(wx: float, wy: float, p: float, nx: int, ny: int) -> float:
    """Place along at which a ray leaves the grid."""
    t = 2.0 * (nx + ny)
    if abs(wx) > EDGE_ON:
        t = min(t, ((nx if wx > 0.0 else 0) + p * wy) / wx)
    if abs(wy) > EDGE_ON:
        t = min(t, ((ny if wy > 0.0 else 0) - p * wx) / wy)
    return t


@inlined
def _lines(
    wx: float,
    wy: float,
    p0: float,
    p1: float,
    near0: float,
    near1: float,
    far0: float,
    far1: float,
    low: float,
    high: float,
    near_line: int,
    far_line: int,
    width: int,
    amount: Vector,
    runs: Vector,
) -> None:
    """Chords on the lines x = i, low <= i <= high; width: cells along them."""
    inverse, shift = 1.0 / wx, 1 if wx > 0.0 else 0
    first = max(int(np.ceil(low - SLIVER)), shift)
    last = min(int(np.floor(high + SLIVER)), runs.shape[0] - 1 + shift)
    for i in range(first, last + 1):
        if i == near_line:
            continue
        t0, t1 = (i + p0 * wy) * inverse, (i + p1 * wy) * inverse
        q0, q1 = p0, p1
        a, b = t0 - near0, t1 - near1
        if a < 0.0:
            if b <= 0.0:
                continue
            q0 = p0 + (p1 - p0) * (a / (a - b))
        elif b < 0.0:
            if a <= 0.0:
                continue
            q1 = p1 - (p1 - p0) * (b / (b - a))
        if i != far_line:
            a, b = far0 - t0, far1 - t1
            if a < 0.0:
                if b <= 0.0:
                    continue
                q0 = max(q0, p0 + (p1 - p0) * (a / (a - b)))
            elif b < 0.0:
                if a <= 0.0:
                    continue
                q1 = min(q1, p1 - (p1 - p0) * (b / (b - a)))
        if q0 >= q1:
            continue
        y0, y1 = (i * wy + q0) * inverse, (i * wy + q1) * inverse
        if y0 > y1:
            y0, y1 = y1, y0
        y0, y1 = max(y0, 0.0), min(y1, float(width))
        if y0 < y1:
            _add_chord(y0, y1, abs(wx), amount, runs[i - shift])


@inlined
def _add_chord(y0: float, y1: float, scale: float, amount: Vector, row: Vector) -> None:
    """row (width + 2, lanes) += the ends of a run from y0 to y1."""
    a, b = int(y0), int(y1)
    f, g = y0 - a, y1 - b
    count = amount.size
    start, after = scale * (1.0 - f), scale * f
    stop, beyond = scale * (1.0 - g), scale * g
    # Four loops: rows a and b may be one, and a loop over both would not be vectorised.
    for k in range(count):
        row[a, k] += start * amount[k]
    for k in range(count):
        row[a + 1, k] += after * amount[k]
    for k in range(count):
        row[b, k] -= stop * amount[k]
    for k in range(count):
        row[b + 1, k] -= beyond * amount[k]
    # Cells from the one that holds y0 to the one that holds y1, slivers aside.
    begin = a if f < 1.0 - SLIVER else a + 1
    end = b if g > SLIVER else b - 1
    if begin <= end:
        row[begin, count] += 1.0
        row[end + 1, count] -= 1.0


@shared
def sum_runs(dx: Vector, dy: Vector, values: Vector) -> None:
    """values (lanes - 1, nx, ny) = running sums of both; exactly 0 where no chord lies.

    Changes dx and dy.
    """
    lanes = dx.shape[2]
    for runs in (dx, dy):
        for i in range(runs.shape[0]):
            for j in range(1, runs.shape[1] - 2):
                for k in range(lanes):
                    runs[i, j, k] += runs[i, j - 1, k]
    for i in range(values.shape[1]):
        for j in range(values.shape[2]):
            if dx[i, j, lanes - 1] + dy[j, i, lanes - 1] > 0.5:
                for k in range(lanes - 1):
                    values[k, i, j] = dx[i, j, k] + dy[j, i, k]
