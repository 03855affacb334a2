"""Single instructions of LLVM assembly on vectors of cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flatland.kernels.layout import VECTOR_BYTES, Layout


class Writer:
    """Lines of assembly, and names for what they compute; one vector holds `lanes` cells.

    table: many numbers are multiplied with, too many for registers. As operands in the text they
    are spread over vectors outside the loop, and hundreds of these wait on the stack; read from a
    table that the compiler has to take for a variable, they are spread by the multiplication itself
    (26 neighbours, 4 bands: 1,600 cycles a vector instead of 2,500).
    """

    def __init__(self, layout: Layout, table: bool = False) -> None:
        self.layout = layout
        self.scalar = "float" if layout.dtype == np.float32 else "double"
        self.vector = f"<{layout.lanes} x {self.scalar}>"
        self.suffix = f"v{layout.lanes}f{8 * layout.dtype.itemsize}"
        self.lines: list[str] = []
        #: Numbers kept in memory, one for each time that one is used; None where they stand in
        #: the instructions.
        self.weights: list[str] | None = [] if table else None
        self._count = 0

    def put(self, line: str) -> None:
        self.lines.append(line)

    def name(self) -> str:
        self._count += 1
        return f"%v{self._count}"

    def declarations(self) -> None:
        """The functions of LLVM that sweeps call, and the mark of a store past the cache."""
        self.put("!0 = !{i32 1}")
        for name, arity in (("fma", 3), ("maxnum", 2)):
            arguments = ", ".join([self.vector] * arity)
            self.put(f"declare {self.vector} @llvm.{name}.{self.suffix}({arguments})")
        self.put(
            f"declare {self.scalar} @llvm.vector.reduce.fadd.{self.suffix}"
            f"({self.scalar}, {self.vector})"
        )

    def address(self, pointer: str, base: str, place: int) -> str:
        at, address = self.name(), self.name()
        self.put(f"  {at} = add i64 {base}, {place}")
        self.put(f"  {address} = getelementptr {self.scalar}, ptr {pointer}, i64 {at}")
        return address

    def load(self, pointer: str, base: str, place: int) -> str:
        address, name = self.address(pointer, base, place), self.name()
        align = self.layout.dtype.itemsize
        self.put(f"  {name} = load {self.vector}, ptr {address}, align {align}")
        return name

    def store(
        self, pointer: str, base: str, place: int, value: str, past_cache: bool = False
    ) -> None:
        """past_cache: to memory at once; the address has to be that of a whole vector."""
        address = self.address(pointer, base, place)
        how = f"align {self.layout.dtype.itemsize}"
        if past_cache:
            how = f"align {VECTOR_BYTES}, !nontemporal !0"
        self.put(f"  store {self.vector} {value}, ptr {address}, {how}")

    def touch(self, pointer: str, base: str, place: int) -> None:
        """Load one number and forget it: its line is in the cache then."""
        address, name = self.address(pointer, base, place), self.name()
        self.put(f"  {name} = load volatile {self.scalar}, ptr {address}")

    def binary(self, operation: str, first: str, second: str) -> str:
        name = self.name()
        self.put(f"  {name} = {operation} {self.vector} {first}, {second}")
        return name

    def call(self, function: str, *arguments: str) -> str:
        name = self.name()
        listed = ", ".join(f"{self.vector} {argument}" for argument in arguments)
        self.put(f"  {name} = call {self.vector} @llvm.{function}.{self.suffix}({listed})")
        return name

    def fused(self, light: str, weight: str, total: str | None) -> str:
        """light · weight + total."""
        if total is None:
            return self.binary("fmul", light, weight)
        return self.call("fma", light, weight, total)

    def masked(self, value: str, column: str) -> str:
        """The value in cells of the grid, zero in the border behind the row's end.

        column: of the vector, as a number or as a name.
        """
        lanes, width = self.layout.lanes, self.layout.width
        if width % lanes == 0:
            return value
        full, kept = width // lanes * lanes, width % lanes
        mask = "<" + ", ".join(f"i1 {int(lane < kept)}" for lane in range(lanes)) + ">"
        if not column.isdecimal():
            whole = "<" + ", ".join(["i1 1"] * lanes) + ">"
            inside, chosen = self.name(), self.name()
            self.put(f"  {inside} = icmp slt i64 {column}, {full}")
            masks = f"<{lanes} x i1> {whole}, <{lanes} x i1> {mask}"
            self.put(f"  {chosen} = select i1 {inside}, {masks}")
            mask = chosen
        name = self.name()
        values = f"{self.vector} {value}, {self.vector} zeroinitializer"
        self.put(f"  {name} = select <{lanes} x i1> {mask}, {values}")
        return name

    def constant(self, number: float) -> str:
        """A vector of one number, in the hexadecimal form that LLVM reads back bit for bit."""
        rounded = float(self.layout.dtype.type(number))
        bits = f"0x{np.float64(rounded).view(np.uint64):016X}"
        if self.weights is not None:
            return self._from_table(f"{self.scalar} {bits}")
        return "<" + ", ".join([f"{self.scalar} {bits}"] * self.layout.lanes) + ">"

    def _from_table(self, number: str) -> str:
        assert self.weights is not None
        self.weights.append(number)
        at, one = self.name(), self.name()
        place = len(self.weights) - 1
        self.put(f"  {at} = getelementptr {self.scalar}, ptr %weights, i64 {place}")
        self.put(f"  {one} = load {self.scalar}, ptr {at}")
        return self._splat(one)

    def find_table(self) -> None:
        """Its address, by a way that keeps the compiler from reading numbers ahead of the loop."""
        if self.weights is not None:
            self.put("  %weights_at = alloca ptr\n  store volatile ptr @weights, ptr %weights_at")
            self.put("  %weights = load volatile ptr, ptr %weights_at")

    def table(self) -> None:
        """The table itself, once all is written."""
        if self.weights is not None:
            kind = f"[{len(self.weights)} x {self.scalar}]"
            self.put(f"@weights = internal global {kind} [{', '.join(self.weights)}]")

    def _splat(self, number: str) -> str:
        """A vector of one scalar."""
        one, name = self.name(), self.name()
        lane = f"<{self.layout.lanes} x i32> zeroinitializer"
        self.put(f"  {one} = insertelement {self.vector} poison, {self.scalar} {number}, i64 0")
        self.put(f"  {name} = shufflevector {self.vector} {one}, {self.vector} poison, {lane}")
        return name

    def spread(self, number: str) -> str:
        """A vector of the number in a double."""
        if self.scalar == "double":
            return self._splat(number)
        narrow = self.name()
        self.put(f"  {narrow} = fptrunc double {number} to float")
        return self._splat(narrow)

    def add_to(self, pointer: str, position: int, vector: str) -> None:
        """Add the sum over a vector to a double at a position of a list."""
        total, wide, place, old, new = (self.name() for _ in range(5))
        self.put(
            f"  {total} = call reassoc {self.scalar} @llvm.vector.reduce.fadd.{self.suffix}"
            f"({self.scalar} 0.0, {self.vector} {vector})"
        )
        if self.scalar == "float":
            self.put(f"  {wide} = fpext float {total} to double")
        else:
            wide = total
        self.put(f"  {place} = getelementptr double, ptr {pointer}, i64 {position}")
        self.put(f"  {old} = load double, ptr {place}")
        self.put(f"  {new} = fadd double {old}, {wide}\n  store double {new}, ptr {place}")

    def joined(
        self, first: Sequence[str], origin: str, second: Sequence[str], other: str
    ) -> list[str]:
        """Values that come from one block or another."""
        names = [self.name() for _ in first]
        for name, a, b in zip(names, first, second):
            self.put(f"  {name} = phi {self.vector} [{a}, %{origin}], [{b}, %{other}]")
        return names
