"""The loop over rows that a sweep's text stands in."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flatland.kernels.writer import Writer


class Frame:
    """Function, rows and the end of a row; what is between begins at `%row_base`.

    boxed: rows and columns of a box that is given at run time, see `box.sweep_box`.
    """

    def __init__(self, writer: Writer, boxed: bool) -> None:
        self.writer, self.layout, self.boxed = writer, writer.layout, boxed
        self._put = writer.put

    def begin(self, prepare: Callable[[], None]) -> None:
        """Up to the first column of a row, in block `row`. prepare: writes what comes before."""
        layout = self.layout
        outer = layout.strides[-3] if len(layout.shape) == 3 else 0
        self.writer.declarations()
        self._put(
            "define void @sweep(ptr noalias readonly %S, ptr noalias %T, ptr noalias %X, "
            "ptr noalias readonly %tau, i64 %first_row, i64 %last_row, "
            "ptr noalias readonly %box, ptr noalias %sums) {"
        )
        self._put("entry:")
        prepare()
        inner, plane, row = str(layout.shape[-2]), "0", "0"
        if self.boxed:
            self._box()
            inner, plane, row = "%inner", "%plane", "%row_0"
        self._put("  %any = icmp slt i64 %first_row, %last_row")
        self._put("  br i1 %any, label %row, label %end")
        self._put("row:\n  %r = phi i64 [%first_row, %entry], [%next_row, %row_end]")
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

    def end(self, sums: Sequence[str]) -> None:
        """Sums of the row to those of all, and the next row."""
        for position, name in enumerate(sums):
            self.writer.add_to("%sums", position, name)
        self._put("  br label %row_end\nrow_end:\n  %next_row = add i64 %r, 1")
        self._put("  %more_rows = icmp slt i64 %next_row, %last_row")
        self._put("  br i1 %more_rows, label %row, label %end\nend:\n  ret void\n}")
