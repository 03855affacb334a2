"""Beams through a medium: every face by itself, as light fades along each ray.

What passes a face, or stops on an edge, between two rays is ∫ e^(-σ d(p)) dp with a distance d
from the near edge that is linear in p, a closed form. What a cell gets less what it gives collides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.beams import EDGE_ON
from propagators.analytic.compiling import inner, shared
from propagators.beam.strips import Surfaces, View, along, element_at, make_view, turn
from propagators.beam.tracing import SLIVER
from propagators.beam.walking import find_beams, make_beams, set_amount

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells; a point this far ahead of an edge, or behind it, tells which cell the edge lies in.
_PROBE = 1e-9
#: σ times a difference of distances below which the integral is a series.
_EVEN = 1e-2


class FadedTally(NamedTuple):
    """What beams leave behind. cells: (nx, ny, C * size). arrived: (E, 2, C). left: (C,).

    collided: (nx, ny, C).
    """

    cells: Vector
    arrived: Vector
    left: Vector
    collided: Vector


class _Beam(NamedTuple):
    """One element's beam in the frame of its own direction.

    p0: its first ray. near, slope: t at p0 and dt/dp of the edge that sends. extinction: per cell.
    """

    wx: float
    wy: float
    p0: float
    near: float
    slope: float
    extinction: float


@shared
def carry_faded(
    directions: Vector,
    harmonics: Vector,
    weight: float,
    extinction: float,
    surfaces: Surfaces,
    radiance: Vector,
    order: Counts,
    tally: FadedTally,
) -> None:
    """As `carry`, through a medium. extinction: collisions per cell length, above 0.

    harmonics: (2, K, size), times the weight [rad].
    """
    view, beams = make_view(surfaces, order), make_beams(surfaces)
    colours = radiance.shape[2]
    amount, flux = np.empty(colours * harmonics.shape[2]), np.empty(colours)
    for k in range(directions.shape[0]):
        wx, wy = directions[k, 0], directions[k, 1]
        turn(wx, wy, surfaces, view)
        for n in range(find_beams(surfaces, view, beams)):
            sent = radiance[beams.elements[n], beams.sides[n, 0]]
            for colour in range(colours):
                flux[colour] = weight * sent[colour]
            set_amount(sent, harmonics[beams.ways[n], k], amount)
            _send(
                1.0 - 2.0 * beams.ways[n], wx, wy, beams.pieces[n, 0], beams.pieces[n, 1],
                beams.sides[n, 1], beams.across[n, 0], beams.across[n, 1], extinction, amount, flux,
                surfaces, view, tally,
            )  # fmt: skip


@inner
def _send(
    sign: float, wx: float, wy: float, sender: int, receiver: int, facing: int, low: float,
    high: float, extinction: float, amount: Vector, flux: Vector, surfaces: Surfaces, view: View,
    tally: FadedTally,
) -> None:  # fmt: skip
    """One element's beam. sign: -1 along the opposite of the ordinate, whose p and t are used."""
    p0, p1 = (low, high) if sign > 0.0 else (-high, -low)
    near0, near1 = sign * along(sender, sign * p0, view), sign * along(sender, sign * p1, view)
    beam = _Beam(sign * wx, sign * wy, p0, near0, (near1 - near0) / (p1 - p0), extinction)
    has_end = receiver < surfaces.pieces.shape[0]
    far0 = far1 = math.inf
    stops = surfaces.lines[sender]
    _edge(beam, p0, p1, near0, near1, 1.0, flux, tally)
    if has_end:
        far0, far1 = (
            sign * along(receiver, sign * p0, view),
            sign * along(receiver, sign * p1, view),
        )
        stops = surfaces.lines[receiver]
        _edge(beam, p0, p1, far0, far1, -1.0, flux, tally)
        place = low
        while place < high:
            e, end = element_at(receiver, place, surfaces, view)
            end = min(end, high)
            a, b = (place, end) if sign > 0.0 else (-end, -place)
            share = _passing(
                beam, a, b, sign * along(receiver, sign * a, view),
                sign * along(receiver, sign * b, view),
            )  # fmt: skip
            for colour in range(flux.size):
                tally.arrived[e, facing, colour] += share * flux[colour]
            place = end
    starts = surfaces.lines[sender]
    if abs(beam.wx) > EDGE_ON:
        _cross(beam, 0, p1, near1, far0, far1, starts[0], stops[0], has_end, amount, flux, tally)
    if abs(beam.wy) > EDGE_ON:
        _cross(beam, 1, p1, near1, far0, far1, starts[1], stops[1], has_end, amount, flux, tally)


@inner
def _passing(beam: _Beam, a: float, b: float, t_a: float, t_b: float) -> float:
    """∫ e^(-σ (t - near)) dp from a to b, with t linear from t_a to t_b."""
    x = beam.extinction * (t_a - beam.near - (a - beam.p0) * beam.slope)
    y = beam.extinction * (t_b - beam.near - (b - beam.p0) * beam.slope)
    x, y = max(x, 0.0), max(y, 0.0)
    half = 0.5 * (y - x)
    if abs(half) < _EVEN:
        square = half * half
        even = 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0))
        return (b - a) * math.exp(-0.5 * (x + y)) * even
    return (b - a) * (math.exp(-x) - math.exp(-y)) / (y - x)


@inner
def _edge(
    beam: _Beam, p0: float, p1: float, t0: float, t1: float, sign: float, flux: Vector,
    tally: FadedTally,
) -> None:  # fmt: skip
    """What starts (sign 1) or stops (-1) on an edge, cell by cell along it.

    What starts on the border and goes outwards has left.
    """
    nx, ny = tally.collided.shape[0], tally.collided.shape[1]
    x0, y0 = t0 * beam.wx - p0 * beam.wy, t0 * beam.wy + p0 * beam.wx
    x1, y1 = t1 * beam.wx - p1 * beam.wy, t1 * beam.wy + p1 * beam.wx
    dx, dy, done = x1 - x0, y1 - y0, 0.0
    while done < 1.0:
        # To the next grid line, a little way beyond what is done.
        x, y = x0 + done * dx, y0 + done * dy
        stop = 1.0
        if dx != 0.0:
            line = math.floor(x + SLIVER) + 1.0 if dx > 0.0 else math.ceil(x - SLIVER) - 1.0
            stop = min(stop, (line - x0) / dx)
        if dy != 0.0:
            line = math.floor(y + SLIVER) + 1.0 if dy > 0.0 else math.ceil(y - SLIVER) - 1.0
            stop = min(stop, (line - y0) / dy)
        stop = max(stop, min(1.0, done + SLIVER))
        middle = 0.5 * (done + stop)
        i = math.floor(x0 + middle * dx + sign * _PROBE * beam.wx)
        j = math.floor(y0 + middle * dy + sign * _PROBE * beam.wy)
        share = _passing(
            beam, p0 + done * (p1 - p0), p0 + stop * (p1 - p0), t0 + done * (t1 - t0),
            t0 + stop * (t1 - t0),
        )  # fmt: skip
        for colour in range(flux.size):
            if 0 <= i < nx and 0 <= j < ny:
                tally.collided[i, j, colour] += sign * share * flux[colour]
            elif sign > 0.0:
                tally.left[colour] += share * flux[colour]
        done = stop


@inner
def _cross(
    beam: _Beam, axis: int, p1: float, near1: float, far0: float, far1: float, start_line: int,
    stop_line: int, has_end: bool, amount: Vector, flux: Vector, tally: FadedTally,
) -> None:  # fmt: skip
    """Faces across one axis: what passes them leaves one cell and enters the next.

    w, v: direction across the faces and along them; q = p, with its sign changed for the y axis, is
    the place across, so that u v + q = c w on the line u, c the coordinate along it.
    """
    shape = tally.collided.shape
    w, v = (beam.wx, beam.wy) if axis == 0 else (beam.wy, beam.wx)
    turned = 1.0 if axis == 0 else -1.0
    p0, near0 = beam.p0, beam.near
    reach = 2.0 * (shape[0] + shape[1])
    end0, end1 = min(far0, near0 + reach), min(far1, near1 + reach)
    low = high = near0 * w - turned * p0 * v
    for t, p in ((near1, p1), (end0, p0), (end1, p1)):
        u = t * w - turned * p * v
        low, high = min(low, u), max(high, u)
    first = max(math.ceil(low - SLIVER), 0)
    last = min(math.floor(high + SLIVER), shape[axis])
    width = float(shape[1 - axis])
    for line in range(first, last + 1):
        if line == start_line:
            continue
        t0, t1 = (line + turned * p0 * v) / w, (line + turned * p1 * v) / w
        a, b = p0, p1
        x, y = t0 - near0, t1 - near1
        if x <= 0.0 and y <= 0.0:
            continue
        if x < 0.0:
            a = p0 + (p1 - p0) * (x / (x - y))
        elif y < 0.0:
            b = p1 - (p1 - p0) * (y / (y - x))
        ends_here = has_end and line == stop_line
        if has_end and not ends_here:
            x, y = far0 - t0, far1 - t1
            if x <= 0.0 and y <= 0.0:
                continue
            if x < 0.0:
                a = max(a, p0 + (p1 - p0) * (x / (x - y)))
            elif y < 0.0:
                b = min(b, p1 - (p1 - p0) * (y / (y - x)))
        # Only what lies in the grid.
        c_a, c_b = (line * v + turned * a) / w, (line * v + turned * b) / w
        lower, upper = max(min(c_a, c_b), 0.0), min(max(c_a, c_b), width)
        cell = math.floor(lower + SLIVER)
        while lower < upper - SLIVER and cell < width:
            stop = min(upper, cell + 1.0)
            pa, pb = turned * (lower * w - line * v), turned * (stop * w - line * v)
            if pa > pb:
                pa, pb = pb, pa
            share = _passing(
                beam, pa, pb, (line + turned * pa * v) / w, (line + turned * pb * v) / w
            )
            _pass_face(axis, line, cell, w > 0.0, ends_here, share, amount, flux, tally)
            lower = stop
            cell += 1


@inner
def _pass_face(
    axis: int, line: int, cell: int, forward: bool, ends_here: bool, share: float, amount: Vector,
    flux: Vector, tally: FadedTally,
) -> None:  # fmt: skip
    """Light leaves the cell before a face and enters the one behind, unless it ends on the face."""
    before, behind = (line - 1, line) if forward else (line, line - 1)
    count = tally.collided.shape[axis]
    if 0 <= before < count:
        i, j = (before, cell) if axis == 0 else (cell, before)
        for m in range(amount.size):
            tally.cells[i, j, m] += share * amount[m]
        if ends_here:
            return
        for colour in range(flux.size):
            tally.collided[i, j, colour] -= share * flux[colour]
    if ends_here:
        return
    inside = 0 <= behind < count
    for colour in range(flux.size):
        if inside:
            i, j = (behind, cell) if axis == 0 else (cell, behind)
            tally.collided[i, j, colour] += share * flux[colour]
        else:
            tally.left[colour] += share * flux[colour]
