"""Light that walls send to one another: radiosity, with form factors from global lines.

The radiosity B of each side i of an element, with albedo ρ and irradiance E from the lights, is

    B_i = ρ_i (E_i + Σ_j F_ij B_j)

(Goral, Torrance, Greenberg and Battaile 1984). Lines of even density along evenly spread directions
meet a side in proportion to its area, and the share of them that leads to another side is the form
factor between the two (Sbert 1993). A line serves both its sides: exchange is symmetric. Lines
sample areas too, by some per cent; scaling rows and columns alike until every side has the lines
that its area asks for (Knight, Ruiz & Uçar 2014) makes light that is sent arrive in full, and
rows of F sum up to 1 together with what leaves the grid: a furnace is exact, whatever the number
of lines. What is sampled is how light is distributed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from propagators.analytic.radiosity import solve_radiosity
from propagators.analytic_3d.directions import Beams
from propagators.analytic_3d.elements import Elements
from propagators.analytic_3d.geometry import Geometry
from propagators.analytic_3d.traces import seen_pairs

Array = NDArray[np.float64]

#: Lines per cell side, in every direction.
DENSITY = 2.0
#: Directions whose lines are held at once.
_BATCH = 128
#: Steps of balancing, each of which halves what is missing or better, and bounds of its factors.
_BALANCING, _LARGEST_FACTOR = 20, 8.0


@dataclass(frozen=True, eq=False)
class Bounced:
    """Light between sides (2 N,) of elements. incoming, radiosity: (2 N, C) flux per cell face.

    open_share: (2 N,) share of what a side sends that leaves the grid.
    """

    elements: Elements
    incoming: Array
    radiosity: Array
    open_share: Array


def bounce(geometry: Geometry, elements: Elements, direct: Array, beams: Beams) -> Bounced:
    """All bounces, from the irradiance (2 N, C) that lights give directly."""
    exchange, open_lines = _balanced(
        *exchange_matrix(elements, beams, geometry.grid.shape), np.pi * elements.side_areas
    )
    lines = np.asarray(exchange.sum(axis=1)).ravel() + open_lines
    met = np.where(lines > 0, lines, 1.0)
    albedo = geometry.albedo[elements.side_owners]
    active = np.flatnonzero((lines > 0) & np.any(albedo > 0, axis=1))
    between = exchange[active][:, active]
    radiosity = np.zeros_like(direct)
    source = direct[active] * lines[active, None]
    # The solver speaks of lengths and of twice their form factors, as in 2D.
    radiosity[active] = solve_radiosity(2 * between, lines[active], albedo[active], source)
    incoming = direct + (exchange @ radiosity) / met[:, None]
    # Sides that no line meets are too small to matter to others.
    radiosity = np.where((lines > 0)[:, None], albedo * incoming, 0.0)
    return Bounced(elements, incoming, radiosity, open_lines / met)


def mean_of(first: Bounced, second: Bounced) -> Bounced:
    """The mean of two independent answers."""
    pairs = zip(
        (first.incoming, first.radiosity, first.open_share),
        (second.incoming, second.radiosity, second.open_share),
    )
    return Bounced(first.elements, *((a + b) / 2 for a, b in pairs))


def exchange_matrix(
    elements: Elements, beams: Beams, shape: tuple[int, ...]
) -> tuple[sparse.csr_array, Array]:
    """Lines between sides, symmetric (2 N, 2 N), and into the open (2 N,); π a square cell."""
    sides = 2 * len(elements.areas)
    exchange = sparse.csr_array((sides, sides))
    open_lines = np.zeros(sides)
    weights = line_weights(beams, len(beams.directions))
    for start in range(0, len(weights), _BATCH):
        part = beams.part(start, start + _BATCH)
        first, second, direction = seen_pairs(*part, DENSITY, elements.rasters, shape)
        weight = weights[start + direction]
        for side, other in ((first, second), (second, first)):
            leaves = other < 0
            open_lines += np.bincount(side[leaves], weight[leaves], sides)
        both = (first >= 0) & (second >= 0)
        entries = weight[both], (first[both], second[both])
        exchange += sparse.coo_array(entries, shape=(sides, sides)).tocsr()
    return exchange + exchange.T, open_lines


def _balanced(
    exchange: sparse.csr_array, open_lines: Array, wanted: Array
) -> tuple[sparse.csr_array, Array]:
    """Exchange and lines into the open, scaled so that sides have the lines wanted.

    Sides that no line meets stay without. Where that cannot be, as among a few tiny elements, the
    factors stay bounded.
    """
    factors = np.ones(len(wanted))
    for _ in range(_BALANCING):
        lines = factors * (exchange @ factors + open_lines)
        better = factors * np.sqrt(wanted / np.where(lines > 0, lines, wanted))
        factors = np.clip(better, 1 / _LARGEST_FACTOR, _LARGEST_FACTOR)
    scale = sparse.diags_array(factors)
    return sparse.csr_array(scale @ exchange @ scale), factors * open_lines


def line_weights(beams: Beams, count: int) -> Array:
    """∫ n·ω dω dA that each line of a direction stands for, if `count` fill half the sphere."""
    return np.asarray(2 * np.pi / count * beams.directions.max(axis=1) / DENSITY**2)
