"""Where the light that a vector of cells gets is written, as assembly: at once or row by row."""

from __future__ import annotations

from collections.abc import Sequence

from flatland.kernels.recipe import Recipe
from flatland.kernels.writer import Writer

#: Vectors of one component that are kept before they are written, at most, and bytes of all.
_LONGEST, _KEPT_BYTES = 8, 16384


class Storing:
    """Writes one value of one component where the recipe wants it, and adds to the row's sums."""

    def __init__(self, writer: Writer, recipe: Recipe) -> None:
        self.writer, self.recipe = writer, recipe
        #: Sums that are kept over a row: those of components, then that of squares.
        self.sums = len(recipe.sums) + 1 if recipe.kind == "step" else 0
        #: Those of a combination, each spread over a vector.
        self.factors: list[str] = []

    def find_factors(self) -> None:
        """Read the three numbers of a combination."""
        for i in range(3) if self.recipe.kind == "combine" else ():
            at, number = self.writer.name(), self.writer.name()
            self.writer.put(f"  {at} = getelementptr double, ptr %sums, i64 {i}")
            self.writer.put(f"  {number} = load double, ptr {at}")
            self.factors.append(self.writer.spread(number))

    def zeros(self) -> list[str]:
        return ["zeroinitializer"] * self.sums

    def store(
        self, base: str, place: int, output: int, value: str, sums: Sequence[str]
    ) -> list[str]:
        """The value goes to `base` + `place`; returns the names of the sums with it."""
        if self.recipe.kind == "combine":
            self._combination(base, place, value)
            return []
        self.writer.store("%T", base, place, value, past_cache=self.recipe.large)
        old = self.writer.load("%X", base, place)
        self.writer.store("%X", base, place, self.writer.binary("fadd", old, value))
        result = list(sums)
        if output in self.recipe.sums:
            position = self.recipe.sums.index(output)
            result[position] = self.writer.binary("fadd", result[position], value)
        result[-1] = self.writer.call("fma", value, value, result[-1])
        return result

    def _combination(self, base: str, place: int, value: str) -> None:
        result = self.writer.binary("fmul", value, self.factors[2])
        for pointer, factor in (("%S", self.factors[0]), ("%X", self.factors[1])):
            light = self.writer.load(pointer, base, place)
            result = self.writer.call("fma", light, factor, result)
        self.writer.store("%T", base, place, result)


class Stage:
    """Values of a piece of a row, component by component, and the loops that write them out.

    Vector by vector, a row of many components is that many streams through memory for each of
    source, target and total, which no prefetcher follows: 25 components on 64³ cells take 1.4 times
    as long. From here they are written in the order in which they lie, and the rows of the source
    that the next row is the first to need are touched in between. Where all fits into the cache
    there is nothing to gain.
    """

    def __init__(self, writer: Writer, storing: Storing, ahead: int) -> None:
        self.writer, self.storing, self._ahead = writer, storing, ahead
        layout = writer.layout
        vectors = -(-layout.width // layout.lanes)
        room = _KEPT_BYTES // (layout.components * layout.lanes * layout.dtype.itemsize)
        self.length = max(1, min(_LONGEST, vectors, room)) * layout.lanes

    def allocate(self) -> None:
        count = self.length // self.writer.layout.lanes * self.writer.layout.components
        self.writer.put(f"  %stage = alloca {self.writer.vector}, i64 {count}, align 64")

    def keep(self, place: str, output: int, value: str) -> None:
        """place: of the vector in its piece of the row."""
        self.writer.store("%stage", place, output * self.length, value)

    def write_out(self, first: str, last: str, sums: list[str]) -> list[str]:
        """Loops over the kept vectors of columns `first` to `last`, one per component.

        Begins in a block of its own, `out`, that the caller jumps to; returns the sums, and ends in
        a block that goes on.
        """
        put = self.writer.put
        put("  br label %out0\nout0:")
        for k in range(self.writer.layout.components):
            sums = self._component(k, first, last, sums)
        return sums

    def _component(self, k: int, first: str, last: str, sums: list[str]) -> list[str]:
        writer, layout = self.writer, self.writer.layout
        writer.put(f"  br label %write{k}\nwrite{k}:")
        writer.put(f"  %c{k} = phi i64 [{first}, %out{k}], [%next_c{k}, %write{k}]")
        starts = [writer.name() for _ in sums]
        place = len(writer.lines)
        kept, base = writer.name(), writer.name()
        writer.put(f"  {kept} = sub i64 %c{k}, {first}")
        writer.put(f"  {base} = add i64 %row_base, %c{k}")
        value = writer.load("%stage", kept, k * self.length)
        value = writer.masked(value, f"%c{k}")
        component = k * layout.component_stride
        results = self.storing.store(base, component, k, value, starts)
        writer.touch("%S", base, component + self._ahead)
        writer.lines[place:place] = [
            f"  {start} = phi {writer.vector} [{before}, %out{k}], [{after}, %write{k}]"
            for start, before, after in zip(starts, sums, results)
        ]
        writer.put(f"  %next_c{k} = add i64 %c{k}, {layout.lanes}")
        writer.put(f"  %more_c{k} = icmp slt i64 %next_c{k}, {last}")
        writer.put(f"  br i1 %more_c{k}, label %write{k}, label %out{k + 1}\nout{k + 1}:")
        return results
