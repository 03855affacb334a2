"""The sweep of one stencil, written out as LLVM assembly.

A stencil is known before the loop runs: which coefficients couple, by how much, and how far apart
they lie in memory. Written out, every number is an immediate operand, zero entries cost nothing
and all outputs of a cell are built in registers from one read of its neighbours. Measured at
512² cells in float32, this takes 0.3 to 0.6 of the time of the same loop written with arrays in
Numba, and compiles in 15 to 60 ms instead of seconds.

Symbols inside the text: S source, T target, X accumulated or right-hand side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.arrivals import Arrivals, written_operations
from flatland.kernels.frame import Frame
from flatland.kernels.layout import Layout
from flatland.kernels.recipe import Recipe
from flatland.kernels.shares import header_of, is_written_twice, vectors_of
from flatland.kernels.storing import Stage, Storing
from flatland.kernels.writer import Writer
from flatland.stencil import Stencil

#: Outputs held in registers at once.
REGISTER_TILE = 32
#: Operations of a cell above which their numbers are read from a table.
LARGEST_OPERANDS = 250


class SweepText:
    """Writes one function `sweep(S, T, X, tau, first_row, last_row, box, sums)`.

    Rows are those of the grid; or, `boxed`, of the box whose place `box` gives in five numbers, see
    `box.sweep_box`.
    """

    def __init__(self, stencil: Stencil, layout: Layout, recipe: Recipe) -> None:
        self.layout, self.recipe = layout, recipe
        operations = written_operations(stencil)
        self.writer = Writer(layout, table=operations > LARGEST_OPERANDS)
        self._put, self._name = self.writer.put, self.writer.name
        self.arrivals = Arrivals(self.writer, stencil)
        self._parities = stencil.basis.parities
        self.storing = Storing(self.writer, recipe)
        self.frame = Frame(self.writer, recipe.boxed)
        #: Whether vectors of cells that no wall is near go without τ; written twice, it compiles
        #: twice as long.
        self.skips = recipe.blocked and is_written_twice(operations)
        self.stage: Stage | None = None
        if recipe.large and len(layout.shape) == 3:
            # The next row's light of the last neighbour, along the row's own columns.
            rows = max(self.arrivals.shifts) // layout.strides[-2] + 1
            self.stage = Stage(self.writer, self.storing, rows * layout.strides[-2])

    def text(self) -> str:
        self.frame.begin(self._prepare)
        self.frame.end(self._staged() if self.stage else self._direct())
        self.writer.table()
        return "\n".join(self.writer.lines) + "\n"

    def _prepare(self) -> None:
        """What is done once, before the first row."""
        if self.stage:
            self.stage.allocate()
        self.writer.find_table()
        self.storing.find_factors()

    # -- a row, vector by vector ----------------------------------------------------------------

    def _direct(self) -> list[str]:
        full = self.layout.width // self.layout.lanes * self.layout.lanes
        sums = self._loop(full) if full else self.storing.zeros()
        return self._rest(full, sums) if full < self.layout.width else sums

    def _loop(self, full: int) -> list[str]:
        """The loop over full vectors of a row; returns the names of its sums."""
        boxed, last = self.recipe.boxed, "%joined" if self.skips else "%column"
        begin, end = ("%first_column", "%full_end") if boxed else ("0", str(full))
        jump = "i1 %any_full, label %column, label %after" if boxed else "label %column"
        self._put(f"  br {jump}\ncolumn:")
        self._put(f"  %j = phi i64 [{begin}, %row], [%next_j, {last}]")
        starts = [f"%sum_in_{i}" for i in range(self.storing.sums)]
        place = len(self.writer.lines)
        base = self._name()
        self._put(f"  {base} = add i64 %row_base, %j")
        results = self._with_or_without_walls(base, "%j", starts)
        # The phi nodes need the names of what the loop's body ends with.
        phis = [
            f"  {start} = phi {self.writer.vector} [zeroinitializer, %row], [{result}, {last}]"
            for start, result in zip(starts, results)
        ]
        self.writer.lines[place:place] = phis
        self._put(f"  %next_j = add i64 %j, {self.layout.lanes}")
        self._put(f"  %more = icmp slt i64 %next_j, {end}")
        self._put("  br i1 %more, label %column, label %after\nafter:")
        if not boxed:
            return results
        return self.writer.joined(self.storing.zeros(), "row", results, last[1:])

    def _rest(self, full: int, sums: list[str]) -> list[str]:
        """The vector at the end of a row that holds fewer cells than lanes, if the box has it."""
        before = "after" if full else "row"
        if self.recipe.boxed:
            self._put("  br i1 %any_rest, label %rest, label %all\nrest:")
        shares = self._shares_at(str(full))[1] if self.recipe.blocked else None
        results = self._vector("%row_base", full, sums, shares, column=str(full))
        if not self.recipe.boxed:
            return results
        self._put("  br label %all\nall:")
        return self.writer.joined(sums, before, results, "rest")

    # -- a row, piece by piece ------------------------------------------------------------------

    def _staged(self) -> list[str]:
        """Pieces of a row, each first kept and then written out."""
        assert self.stage is not None
        lanes, storing = self.layout.lanes, self.storing
        begin, end = "0", str(vectors_of(self.layout) * lanes)
        if self.recipe.boxed:
            begin, end = "%first_column", "%last_column"
        last, behind = "%joined" if self.skips else "%column", f"%out{self.layout.components}"
        self._put(f"  br label %piece\npiece:\n  %from = phi i64 [{begin}, %row], [%to, {behind}]")
        starts = [f"%sum_in_{i}" for i in range(storing.sums)]
        place = len(self.writer.lines)
        self._put(f"  %far = add i64 %from, {self.stage.length}")
        self._put(f"  %near_end = icmp slt i64 %far, {end}")
        self._put(f"  %to = select i1 %near_end, i64 %far, i64 {end}")
        self._put(f"  br label %column\ncolumn:\n  %j = phi i64 [%from, %piece], [%next_j, {last}]")
        base = self._name()
        self._put(f"  {base} = add i64 %row_base, %j\n  %kept = sub i64 %j, %from")
        self._with_or_without_walls(base, "%j", [])
        self._put(f"  %next_j = add i64 %j, {lanes}\n  %more = icmp slt i64 %next_j, %to")
        self._put("  br i1 %more, label %column, label %out\nout:")
        results = self.stage.write_out("%from", "%to", starts)
        self.writer.lines[place:place] = [
            f"  {start} = phi {self.writer.vector} [zeroinitializer, %row], [{result}, {behind}]"
            for start, result in zip(starts, results)
        ]
        self._put(f"  %more_pieces = icmp slt i64 %to, {end}")
        self._put("  br i1 %more_pieces, label %piece, label %after\nafter:")
        return results

    # -- one vector of cells --------------------------------------------------------------------

    def _with_or_without_walls(self, base: str, column: str, starts: list[str]) -> list[str]:
        """A vector's cells without τ where no wall stops light on its way there, else with it."""
        if not self.recipe.blocked:
            return self._vector(base, 0, starts, None)
        block, shares = self._shares_at(column)
        if not self.skips:
            return self._vector(base, 0, starts, shares)
        clear_of_walls = self._name()
        self._put(f"  {clear_of_walls} = icmp slt i64 {block}, 0")
        self._put(f"  br i1 {clear_of_walls}, label %clear, label %walls\nclear:")
        clear = self._vector(base, 0, starts, None)
        self._put("  br label %joined\nwalls:")
        walls = self._vector(base, 0, starts, shares)
        self._put("  br label %joined\njoined:")
        return self.writer.joined(clear, "clear", walls, "walls")

    def _shares_at(self, column: str) -> tuple[str, str]:
        """The τ of the vector at a column of the row: its number of a block, and its position."""
        j, row, number, at, narrow, block, place, shares = (self._name() for _ in range(8))
        self._put(f"  {j} = udiv i64 {column}, {self.layout.lanes}")
        self._put(f"  {row} = mul i64 %grid_row, {vectors_of(self.layout)}")
        self._put(f"  {number} = add i64 {row}, {j}")
        self._put(f"  {at} = getelementptr {self.writer.scalar}, ptr %tau, i64 {number}")
        self._put(f"  {narrow} = load i32, ptr {at}")
        self._put(f"  {block} = sext i32 {narrow} to i64")
        self._put(f"  {place} = mul i64 {block}, {len(self.arrivals.shifts) * self.layout.lanes}")
        self._put(f"  {shares} = add i64 {place}, {header_of(self.layout)}")
        return block, shares

    def _vector(
        self, base: str, place: int, sums: list[str], shares: str | None, column: str | None = None
    ) -> list[str]:
        """All outputs of one vector of cells that starts at `base` + `place`.

        column: of the vector at the row's end that has cells behind the grid.
        """
        for outputs in self._tiles():
            arrived = self.arrivals.at(base, place, outputs, shares)
            for output in outputs:
                value = arrived.get(output, "zeroinitializer")
                if self.stage:
                    self.stage.keep("%kept", output, value)
                    continue
                if column is not None:
                    value = self.writer.masked(value, column)
                component = place + output * self.layout.component_stride
                sums = self.storing.store(base, component, output, value, sums)
        return sums

    def _tiles(self) -> list[list[int]]:
        """Outputs that are in registers together.

        Parted by their parities: those that differ in one need other sums of an orbit's members,
        so that hardly any is written twice.
        """
        tiles = [list(range(self.layout.components))]
        for parity in self._parities.T:
            tiles = _parted(tiles, parity)
        return [
            tile[i : i + REGISTER_TILE]
            for tile in tiles
            for i in range(0, len(tile), REGISTER_TILE)
        ]


def _parted(tiles: list[list[int]], parity: NDArray[np.int64]) -> list[list[int]]:
    """Tiles that are too large for registers in two, by the parity of their components."""
    result = []
    for tile in tiles:
        if len(tile) <= REGISTER_TILE:
            result.append(tile)
            continue
        parts = [[k for k in tile if parity[k] == sign] for sign in (1, -1)]
        result += [part for part in parts if part]
    return result
