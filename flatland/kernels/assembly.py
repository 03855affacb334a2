"""The sweep of one stencil, written out as LLVM assembly.

A stencil is known before the loop runs: which coefficients couple, by how much, and how far apart
they lie in memory. Written out, every number is an immediate operand, zero entries cost nothing
and all outputs of a cell are built in registers from one read of its neighbours. Measured at
512² cells in float32, this takes 0.3 to 0.6 of the time of the same loop written with arrays in
Numba, and compiles in 15 to 60 ms instead of seconds.

Symbols inside the text: S source, T target, X accumulated or right-hand side.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
from flatland.kernels.shares import header_of, is_written_twice, vectors_of
from flatland.stencil import Stencil

#: Outputs held in registers at once; 16 of the 32 vector registers measured best.
REGISTER_TILE = 16


@dataclass(frozen=True)
class Recipe:
    """What a sweep does with A S, the light that arrives.

    kind="step": T = A S, X += T, and sums of components over the row.
    kind="combine": T = f₀·S + f₁·X + f₂·(A S), X read only, f₀, f₁, f₂ given in `sums`.
    blocked: τ(x, d) multiplies what leaves x along d.
    boxed: rows and columns are those of a box given at run time; costs a little per row, since
    their numbers are not known when the text is compiled.
    """

    kind: str = "step"
    blocked: bool = False
    boxed: bool = False
    #: Components whose sum over cells is returned (the sum of all squares comes last).
    sums: tuple[int, ...] = (0,)


def significant(transfer: NDArray[np.float64]) -> NDArray[np.float64]:
    """Transfer matrices with rounding noise (under 8 ulp of the largest entry) set to zero."""
    limit = 8 * np.finfo(float).eps * np.abs(transfer).max(initial=0.0)
    return np.where(np.abs(transfer) > limit, transfer, 0.0)


class SweepText:
    """Writes one function `sweep(S, T, X, tau, first_row, last_row, box, sums)`.

    Rows are those of the grid; or, `boxed`, of the box whose place `box` gives in five numbers, see
    `box.sweep_box`.
    """

    def __init__(self, stencil: Stencil, layout: Layout, recipe: Recipe) -> None:
        self.layout, self.recipe = layout, recipe
        self.transfer = significant(stencil.transfer)
        self.faces = stencil.clamp
        self.blocked = recipe.blocked
        couplings = int(np.count_nonzero(self.transfer))
        #: Whether vectors of cells that no wall is near go without τ; written twice, it compiles
        #: twice as long.
        self.skips = recipe.blocked and is_written_twice(couplings)
        if stencil.clamp:
            assert stencil.reception is not None
            assert stencil.emission is not None
            self.reception = significant(stencil.reception)
            self.emission = significant(stencil.emission)
        # Gathering: what arrives at x along d was at x - d.
        self.shifts = [-layout.shift(offset) for offset in stencil.offsets]
        self.scalar = "float" if layout.dtype == np.float32 else "double"
        self.vector = f"<{layout.lanes} x {self.scalar}>"
        self.suffix = f"v{layout.lanes}f{8 * layout.dtype.itemsize}"
        #: Position of the τ of the vector that is being written.
        self.shares = ""
        self.lines: list[str] = []
        self.count = 0

    def text(self) -> str:
        self._prologue()
        full = self.layout.width // self.layout.lanes * self.layout.lanes
        sums = self._loop(full) if full else self._zeros()
        if full < self.layout.width:
            sums = self._rest(full, sums)
        self._epilogue(sums)
        return "\n".join(self.lines) + "\n"

    # -- control flow ---------------------------------------------------------------------------

    def _prologue(self) -> None:
        layout, v = self.layout, self.vector
        outer = layout.strides[-3] if len(layout.shape) == 3 else 0
        for name, arity in (("fma", 3), ("maxnum", 2)):
            arguments = ", ".join([v] * arity)
            self._put(f"declare {v} @llvm.{name}.{self.suffix}({arguments})")
        reduce = f"declare {self.scalar} @llvm.vector.reduce.fadd.{self.suffix}({self.scalar}, {v})"
        self._put(reduce)
        self._put(
            "define void @sweep(ptr noalias readonly %S, ptr noalias %T, ptr noalias %X, "
            "ptr noalias readonly %tau, i64 %first_row, i64 %last_row, "
            "ptr noalias readonly %box, ptr noalias %sums) {"
        )
        self._put("entry:")
        if self.recipe.boxed:
            self._box()
        if self.recipe.kind == "combine":
            self._factors()
        self._put("  %any = icmp slt i64 %first_row, %last_row")
        self._put("  br i1 %any, label %row, label %end")
        self._put("row:\n  %r = phi i64 [%first_row, %entry], [%next_row, %row_end]")
        inner, plane, row = str(layout.shape[-2]), "0", "0"
        if self.recipe.boxed:
            inner, plane, row = "%inner", "%plane", "%row_0"
        self._put(f"  %r_outer = udiv i64 %r, {inner}\n  %r_inner = urem i64 %r, {inner}")
        self._put(f"  %p = add i64 %r_outer, {plane}\n  %q = add i64 %r_inner, {row}")
        self._put(f"  %a = mul i64 %p, {outer}\n  %b = mul i64 %q, {layout.strides[-2]}")
        self._put(f"  %of_planes = mul i64 %p, {layout.shape[-2]}")
        self._put("  %grid_row = add i64 %of_planes, %q")
        self._put(f"  %ab = add i64 %a, %b\n  %row_base = add i64 %ab, {layout.front}")

    def _box(self) -> None:
        """Rows and columns of the box, and which kinds of vectors it has."""
        full = self.layout.width // self.layout.lanes * self.layout.lanes
        for i, name in enumerate(("plane", "row_0", "inner", "first_column", "last_column")):
            self._put(f"  %at_{name} = getelementptr i64, ptr %box, i64 {i}")
            self._put(f"  %{name} = load i64, ptr %at_{name}")
        self._put(f"  %cut = icmp slt i64 %last_column, {full}")
        self._put(f"  %full_end = select i1 %cut, i64 %last_column, i64 {full}")
        self._put("  %any_full = icmp slt i64 %first_column, %full_end")
        self._put(f"  %any_rest = icmp sgt i64 %last_column, {full}")

    def _factors(self) -> None:
        """Three numbers, each spread over a vector."""
        lane = f"<{self.layout.lanes} x i32> zeroinitializer"
        for i in range(3):
            at, wide, number, one = (self._name() for _ in range(4))
            self._put(f"  {at} = getelementptr double, ptr %sums, i64 {i}")
            self._put(f"  {wide} = load double, ptr {at}")
            if self.scalar == "float":
                self._put(f"  {number} = fptrunc double {wide} to float")
            else:
                number = wide
            self._put(
                f"  {one} = insertelement {self.vector} poison, {self.scalar} {number}, i64 0"
            )
            self._put(
                f"  %factor_{i} = shufflevector {self.vector} {one}, {self.vector} poison, {lane}"
            )

    def _zeros(self) -> list[str]:
        return ["zeroinitializer"] * (len(self.recipe.sums) + 1)

    def _loop(self, full: int) -> list[str]:
        """The loop over full vectors of a row; returns the names of its sums."""
        boxed, last = self.recipe.boxed, "%joined" if self.skips else "%column"
        begin, end = ("%first_column", "%full_end") if boxed else ("0", str(full))
        jump = "i1 %any_full, label %column, label %after" if boxed else "label %column"
        self._put(f"  br {jump}\ncolumn:")
        self._put(f"  %j = phi i64 [{begin}, %row], [%next_j, {last}]")
        starts = [f"%sum_in_{i}" for i in range(len(self.recipe.sums) + 1)]
        place = len(self.lines)
        base = self._name()
        self._put(f"  {base} = add i64 %row_base, %j")
        if self.skips:
            results = self._clear_or_walls(base, starts)
        else:
            if self.blocked:
                self._shares_at("%j")
            results = self._block(base, 0, starts, masked=False)
        # The phi nodes need the names of what the loop's body ends with.
        phis = [
            f"  {start} = phi {self.vector} [zeroinitializer, %row], [{result}, {last}]"
            for start, result in zip(starts, results)
        ]
        self.lines[place:place] = phis
        self._put(f"  %next_j = add i64 %j, {self.layout.lanes}")
        self._put(f"  %more = icmp slt i64 %next_j, {end}")
        self._put("  br i1 %more, label %column, label %after\nafter:")
        return self._either(self._zeros(), "row", results, last[1:]) if boxed else results

    def _rest(self, full: int, sums: list[str]) -> list[str]:
        """The vector at the end of a row that holds fewer cells than lanes, if the box has it."""
        before = "after" if full else "row"
        if self.recipe.boxed:
            self._put("  br i1 %any_rest, label %rest, label %all\nrest:")
        if self.blocked:
            self._shares_at(str(full))
        results = self._block("%row_base", full, sums)
        if not self.recipe.boxed:
            return results
        self._put("  br label %all\nall:")
        return self._either(sums, before, results, "rest")

    def _either(self, first: list[str], origin: str, second: list[str], other: str) -> list[str]:
        """Sums that come from one block or another."""
        names = [self._name() for _ in first]
        for name, a, b in zip(names, first, second):
            self._put(f"  {name} = phi {self.vector} [{a}, %{origin}], [{b}, %{other}]")
        return names

    def _clear_or_walls(self, base: str, starts: list[str]) -> list[str]:
        """A vector's cells without τ where no wall stops light on its way there, else with it."""
        clear_of_walls = self._name()
        block = self._shares_at("%j")
        self._put(f"  {clear_of_walls} = icmp slt i64 {block}, 0")
        self._put(f"  br i1 {clear_of_walls}, label %clear, label %walls\nclear:")
        self.blocked = False
        clear = self._block(base, 0, starts, masked=False)
        self._put("  br label %joined\nwalls:")
        self.blocked = True
        walls = self._block(base, 0, starts, masked=False)
        self._put("  br label %joined\njoined:")
        return self._either(clear, "clear", walls, "walls")

    def _shares_at(self, column: str) -> str:
        """Find the τ of the vector at a column of the row: its number of a block, returned, and its
        position, kept."""
        j, row, number, at, narrow, block, place, self.shares = (self._name() for _ in range(8))
        self._put(f"  {j} = udiv i64 {column}, {self.layout.lanes}")
        self._put(f"  {row} = mul i64 %grid_row, {vectors_of(self.layout)}")
        self._put(f"  {number} = add i64 {row}, {j}")
        self._put(f"  {at} = getelementptr {self.scalar}, ptr %tau, i64 {number}")
        self._put(f"  {narrow} = load i32, ptr {at}")
        self._put(f"  {block} = sext i32 {narrow} to i64")
        self._put(f"  {place} = mul i64 {block}, {len(self.shifts) * self.layout.lanes}")
        self._put(f"  {self.shares} = add i64 {place}, {header_of(self.layout)}")
        return block

    def _epilogue(self, sums: list[str]) -> None:
        zero = "0.0"
        for position, name in enumerate(sums if self.recipe.kind == "step" else []):
            total, wide, place, old, new = (self._name() for _ in range(5))
            self._put(
                f"  {total} = call reassoc {self.scalar} @llvm.vector.reduce.fadd.{self.suffix}"
                f"({self.scalar} {zero}, {self.vector} {name})"
            )
            if self.scalar == "float":
                self._put(f"  {wide} = fpext float {total} to double")
            else:
                wide = total
            self._put(f"  {place} = getelementptr double, ptr %sums, i64 {position}")
            self._put(f"  {old} = load double, ptr {place}")
            self._put(f"  {new} = fadd double {old}, {wide}\n  store double {new}, ptr {place}")
        self._put("  br label %row_end\nrow_end:\n  %next_row = add i64 %r, 1")
        self._put("  %more_rows = icmp slt i64 %next_row, %last_row")
        self._put("  br i1 %more_rows, label %row, label %end\nend:\n  ret void\n}")

    # -- one vector of cells --------------------------------------------------------------------

    def _block(self, base: str, column: int, sums: list[str], masked: bool = True) -> list[str]:
        """All outputs of one vector of cells that starts at `base` + `column`."""
        for first in range(0, self.layout.components, REGISTER_TILE):
            outputs = range(first, min(first + REGISTER_TILE, self.layout.components))
            arrived = self._clamped(base, column, outputs) if self.faces else {}
            if not self.faces:
                arrived = self._linear(base, column, outputs)
            for output in outputs:
                value = arrived.get(output, "zeroinitializer")
                if masked:
                    value = self._masked(value)
                place = column + output * self.layout.component_stride
                if self.recipe.kind == "step":
                    sums = self._store_step(base, place, output, value, sums)
                else:
                    self._store_combination(base, place, value)
        return sums

    def _linear(self, base: str, column: int, outputs: range) -> dict[int, str]:
        arrived: dict[int, str] = {}
        for d, k, used in self._couplings(outputs):
            light = self._incoming(base, column, d, k)
            for output in used:
                weight = self._constant(self.transfer[d, output, k])
                arrived[output] = self._fused(light, weight, arrived.get(output))
        return arrived

    def _couplings(self, outputs: range) -> Iterator[tuple[int, int, list[int]]]:
        for d in range(len(self.shifts)):
            for k in range(self.layout.components):
                used = [output for output in outputs if self.transfer[d, output, k] != 0.0]
                if used:
                    yield d, k, used

    def _clamped(self, base: str, column: int, outputs: range) -> dict[int, str]:
        """Face fluxes first, negative ones dropped, then the lobes."""
        arrived: dict[int, str] = {}
        for d in range(len(self.shifts)):
            light = [self._incoming(base, column, d, k) for k in range(self.layout.components)]
            for face in range(self.reception.shape[1]):
                flux: str | None = None
                for k in np.flatnonzero(self.reception[d, face]):
                    weight = self._constant(self.reception[d, face, k])
                    flux = self._fused(light[k], weight, flux)
                if flux is None:
                    continue
                kept = self._call("maxnum", flux, "zeroinitializer")
                for output in outputs:
                    if self.emission[d, output, face] != 0.0:
                        weight = self._constant(self.emission[d, output, face])
                        arrived[output] = self._fused(kept, weight, arrived.get(output))
        return arrived

    def _incoming(self, base: str, column: int, d: int, k: int) -> str:
        at = column + self.shifts[d]
        light = self._load("%S", base, at + k * self.layout.component_stride)
        if not self.blocked:
            return light
        passing = self._load("%tau", self.shares, d * self.layout.lanes)
        return self._binary("fmul", light, passing)

    def _store_step(
        self, base: str, place: int, output: int, value: str, sums: list[str]
    ) -> list[str]:
        self._store("%T", base, place, value)
        old = self._load("%X", base, place)
        self._store("%X", base, place, self._binary("fadd", old, value))
        sums = list(sums)
        if output in self.recipe.sums:
            position = self.recipe.sums.index(output)
            sums[position] = self._binary("fadd", sums[position], value)
        sums[-1] = self._call("fma", value, value, sums[-1])
        return sums

    def _store_combination(self, base: str, place: int, value: str) -> None:
        result = self._binary("fmul", value, "%factor_2")
        for pointer, factor in (("%S", "%factor_0"), ("%X", "%factor_1")):
            result = self._call("fma", self._load(pointer, base, place), factor, result)
        self._store("%T", base, place, result)

    # -- single instructions --------------------------------------------------------------------

    def _put(self, line: str) -> None:
        self.lines.append(line)

    def _name(self) -> str:
        self.count += 1
        return f"%v{self.count}"

    def _address(self, pointer: str, base: str, place: int) -> str:
        at, address = self._name(), self._name()
        self._put(f"  {at} = add i64 {base}, {place}")
        self._put(f"  {address} = getelementptr {self.scalar}, ptr {pointer}, i64 {at}")
        return address

    def _load(self, pointer: str, base: str, place: int) -> str:
        address, name = self._address(pointer, base, place), self._name()
        align = self.layout.dtype.itemsize
        self._put(f"  {name} = load {self.vector}, ptr {address}, align {align}")
        return name

    def _store(self, pointer: str, base: str, place: int, value: str) -> None:
        address = self._address(pointer, base, place)
        align = self.layout.dtype.itemsize
        self._put(f"  store {self.vector} {value}, ptr {address}, align {align}")

    def _binary(self, operation: str, first: str, second: str) -> str:
        name = self._name()
        self._put(f"  {name} = {operation} {self.vector} {first}, {second}")
        return name

    def _call(self, function: str, *arguments: str) -> str:
        name = self._name()
        listed = ", ".join(f"{self.vector} {argument}" for argument in arguments)
        self._put(f"  {name} = call {self.vector} @llvm.{function}.{self.suffix}({listed})")
        return name

    def _fused(self, light: str, weight: str, total: str | None) -> str:
        if total is None:
            return self._binary("fmul", light, weight)
        return self._call("fma", light, weight, total)

    def _masked(self, value: str) -> str:
        """The value in cells of the grid, zero in the border behind the row's end."""
        kept = self.layout.width % self.layout.lanes
        mask = ", ".join(f"i1 {int(lane < kept)}" for lane in range(self.layout.lanes))
        name = self._name()
        self._put(
            f"  {name} = select <{self.layout.lanes} x i1> <{mask}>, {self.vector} {value}, "
            f"{self.vector} zeroinitializer"
        )
        return name

    def _constant(self, number: float) -> str:
        """A vector of one number, in the hexadecimal form that LLVM reads back bit for bit."""
        rounded = float(self.layout.dtype.type(number))
        bits = f"0x{np.float64(rounded).view(np.uint64):016X}"
        return "<" + ", ".join([f"{self.scalar} {bits}"] * self.layout.lanes) + ">"
