"""One flight of light along a set of ordinates: from every surface that shines to the next one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from flatland.harmonics import CircularHarmonics
from flatland.kernels.threads import rows_of, run_shared, thread_count
from propagators.beam.carrying import Tally, carry
from propagators.beam.pairs import collect_pairs
from propagators.beam.strips import Surfaces
from propagators.beam.tracing import sum_runs
from propagators.transport.ordinates import Ordinates
from propagators.transport.surface_elements import SurfaceElements

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Waking another thread costs as much as about this many pieces times pairs of ordinates.
_FEW = 300


@dataclass(frozen=True, eq=False)
class Flight:
    """values: (C, size, nx, ny) of what leaves each cell, or without cells (C, 0, nx, ny).

    arrived: (E, 2, C) on each side of each element. emitted, left: (C,).
    """

    values: Array
    arrived: Array
    emitted: Array
    left: Array


@dataclass(frozen=True, eq=False)
class Transport:
    """Surfaces cut in elements, and the ordinates along which they send light."""

    surfaces: SurfaceElements
    ordinates: Ordinates
    shape: tuple[int, int]

    def fly(self, radiance: Array, basis: CircularHarmonics | None) -> Flight:
        """Follow light of radiance (E, 2, C); without a basis, past the cells."""
        surfaces, half = self._for_kernels(radiance), self.ordinates.count // 2
        size = 0 if basis is None else basis.size
        harmonics = np.empty((2, half, 0))
        if basis is not None:
            harmonics = self.ordinates.harmonics(basis).reshape(2, half, size)
        tallies = [self._tally(radiance.shape, size) for _ in range(self._parties())]

        def sweep(party: int, directions: Array, order: Counts, mine: slice) -> None:
            part = np.ascontiguousarray(harmonics[:, mine])
            weight = self.ordinates.weight
            carry(directions, part, weight, surfaces, radiance, order, tallies[party])

        self._share(sweep, len(tallies))
        for other in tallies[1:]:
            for mine, theirs in zip(tallies[0], other):
                mine += theirs
        return _flight(tallies[0], size)

    def exchange(self, sends: NDArray[np.bool_]) -> csr_array:
        """Symmetric X (2 E, 2 E): flux on side 2 e + k per radiance of another, both in `sends`.

        sends: (E, 2).
        """
        surfaces = self._for_kernels(sends[:, :, None])
        parts: list[csr_array] = []

        def sweep(party: int, directions: Array, order: Counts, mine: slice) -> None:
            room = 0
            while True:
                places, widths = np.empty((2, room), np.int32), np.empty(room)
                count = collect_pairs(directions, surfaces, order.copy(), places, widths)
                if count <= room:
                    break
                room = count
            widths = widths[:count] * self.ordinates.weight
            ends = (places[0, :count], places[1, :count])
            parts.append(coo_array((widths, ends), shape=(sends.size, sends.size)).tocsr())

        self._share(sweep, self._parties())
        total = sum(parts[1:], parts[0])
        return csr_array(total + total.T)

    def along(self, direction: Array, radiance: Array) -> Array:
        """Intensity (C, nx, ny) in one direction (2,)."""
        tally = self._tally(radiance.shape, 1)
        harmonics = np.array([1.0, 0.0]).reshape(2, 1, 1)
        order, surfaces = self._order(direction), self._for_kernels(radiance)
        carry(direction[None], harmonics, 1.0, surfaces, radiance, order, tally)
        return _flight(tally, 1).values[:, 0]

    def _share(self, sweep: Callable[[int, Array, Counts, slice], None], parties: int) -> None:
        """Call sweep(party, directions, order, which of the ordinates) for half the circle."""
        half = self.ordinates.count // 2
        directions = self.ordinates.directions[:half]

        def run(party: int, parties: int) -> None:
            mine = slice(*rows_of(party, parties, half))
            sweep(party, directions[mine], self._order(directions[mine.start]), mine)

        run_shared(run, parties)

    def _order(self, direction: Array) -> Counts:
        """Vertices by their place across."""
        across = self.surfaces.arrangement.vertices @ [-direction[1], direction[0]]
        return np.argsort(across, kind="stable")

    def _parties(self) -> int:
        work = len(self.surfaces.arrangement.pieces) * self.ordinates.count // 2
        return thread_count() if work > _FEW else 1

    def _for_kernels(self, radiance: NDArray[np.generic]) -> Surfaces:
        made, elements = self.surfaces.arrangement, self.surfaces.first
        ends = made.pieces.ravel()
        incident = np.argsort(ends, kind="stable")
        first = np.searchsorted(ends[incident], np.arange(len(made.vertices) + 1))
        lit = np.any(radiance != 0, axis=2)
        shines = np.logical_or.reduceat(lit, elements[:-1], axis=0) if len(lit) else lit
        lines, places = (made.vertices, made.pieces, made.lines), incident // 2
        return Surfaces(*lines, first, places, elements, shines)

    def _tally(self, shape: tuple[int, ...], size: int) -> Tally:
        colours, (nx, ny) = shape[2], self.shape
        lanes = colours * size + 1 if size else 0
        return Tally(
            np.zeros((nx, ny + 2, lanes)),
            np.zeros((ny, nx + 2, lanes)),
            np.zeros(shape),
            np.zeros(colours),
            np.zeros(colours),
        )


def _flight(tally: Tally, size: int) -> Flight:
    """Coefficients from the ends of runs; exactly 0 where no beam came."""
    colours, nx, ny = tally.left.size, tally.dx.shape[0], tally.dy.shape[0]
    values = np.zeros((colours * size, nx, ny))
    if size:
        sum_runs(tally.dx, tally.dy, values)
    by_colour = values.reshape(colours, size, nx, ny)
    return Flight(by_colour, tally.arrived, tally.emitted, tally.left)
