"""One scene seen through one plan of a cascade."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics
from flatland.kernels.threads import run_shared, thread_count
from propagators.cascades.face_pieces import FacePieces, cut_faces
from propagators.cascades.levels import Level, Plan
from propagators.cascades.merging import gather_cells, gather_sides, merge_level
from propagators.transport.cell_items import CellItems, Items, items_in_cells
from propagators.transport.problem import DirectProblem
from propagators.transport.rays import parts_by_cell

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cascade:
    """fix: one of the constants of `merging`. node_count: Gauss points on each piece of a face."""

    problem: DirectProblem
    plan: Plan
    fix: int
    node_count: int

    @cached_property
    def levels(self) -> list[Level]:
        return self.plan.levels(self.problem.shape)

    @cached_property
    def _items(self) -> CellItems:
        return items_in_cells(self.problem.surfaces.segments, self.problem.shape)

    @cached_property
    def _parts(self) -> Items:
        return parts_by_cell(self._items, self.problem.shape)

    @cached_property
    def _faces(self) -> FacePieces:
        return cut_faces(self._items, self.problem.shape)

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        """Gauss nodes and weights on [0, 1]."""
        nodes, weights = np.polynomial.legendre.leggauss(self.node_count)
        return 0.5 + 0.5 * nodes, 0.5 * weights

    def upper_radiance(self, radiance: Array) -> Array:
        """Merged radiance of level 1, (probes, bins, C); empty if level 0 is the last.

        radiance: (E, 2, C) of both sides of all elements.
        """
        sides, levels = radiance.reshape(-1, radiance.shape[2]), self.levels
        above = np.zeros((0, 0, sides.shape[1]))
        for number in range(len(levels) - 1, 0, -1):
            lower, upper = levels[number], levels[min(number + 1, len(levels) - 1)]
            shape = (lower.count_x * lower.count_y, len(lower.directions), sides.shape[1])
            merged = np.zeros(shape)

            def merge(
                party: int,
                parties: int,
                levels: tuple[Level, Level] = (lower, upper),
                above: Array = above,
                merged: Array = merged,
            ) -> None:
                branching = 1 if not above.size else above.shape[1] // merged.shape[1]
                merge_level(
                    party, parties, *self._how, branching, *levels, above, self._parts, sides,
                    merged,
                )  # fmt: skip

            run_shared(merge, thread_count())
            above = merged
        return above

    def gather(self, radiance: Array, basis: CircularHarmonics) -> tuple[Array, Array, Array]:
        """Coefficients (C, size, nx, ny), flux arrived (E, 2, C) and left (C,)."""
        above, sides = self.upper_radiance(radiance), radiance.reshape(-1, radiance.shape[2])
        colours, shape = sides.shape[1], self.problem.shape
        tables, parties = self._tables(basis), thread_count()
        cells = np.zeros((*shape, colours, basis.size))
        left = np.zeros((parties, colours))

        def collect(party: int, parties: int) -> None:
            gather_cells(
                party, parties, *self._how, *self._lowest, above, self._parts, sides, self._faces,
                *self._rule, tables, cells, left[party],
            )  # fmt: skip

        run_shared(collect, parties)
        values = np.ascontiguousarray(cells.transpose(2, 3, 0, 1))
        return values, self._arrived(above, sides), left.sum(axis=0)

    def arrived(self, radiance: Array) -> Array:
        """Flux (E, 2, C) on both sides of all elements."""
        sides = radiance.reshape(-1, radiance.shape[2])
        return self._arrived(self.upper_radiance(radiance), sides)

    def _arrived(self, above: Array, sides: Array) -> Array:
        result = np.zeros_like(sides)
        segments = self.problem.surfaces.segments

        def collect(party: int, parties: int) -> None:
            gather_sides(
                party, parties, *self._how, *self._lowest, above, self._parts, sides, segments,
                *self._rule, result,
            )  # fmt: skip

        run_shared(collect, thread_count())
        return result.reshape(-1, 2, sides.shape[1])

    @property
    def _how(self) -> tuple[int, int, int]:
        return self.fix, *self.problem.shape

    @property
    def _lowest(self) -> tuple[Level, Level]:
        return self.levels[0], self.levels[min(1, len(self.levels) - 1)]

    def _tables(self, basis: CircularHarmonics) -> Array:
        """∫ max(0, n·ω) y dω over the bins of level 0, (4, bins, size)."""
        edges = np.linspace(0, 2 * np.pi, self.plan.bins + 1)
        tables = []
        for angle in (np.pi, 0.0, 1.5 * np.pi, 0.5 * np.pi):
            ahead = np.cos(0.5 * (edges[1:] + edges[:-1]) - angle) > 0
            integrals = basis.cosine_arc_integral(edges[:-1], edges[1:], angle)
            tables.append(np.where(ahead[:, None], integrals, 0.0))
        return np.array(tables)
