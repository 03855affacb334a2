"""Plain tables for terminals and pipes."""

from __future__ import annotations

from collections.abc import Sequence


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Columns aligned by their widest entry; numbers to the right, text to the left."""
    cells = [list(header), *[[_text(entry) for entry in row] for row in rows]]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    numeric = [all(not isinstance(row[i], str) for row in rows) for i in range(len(header))]
    lines = [
        "  ".join(
            entry.rjust(width) if right else entry.ljust(width)
            for entry, width, right in zip(row, widths, numeric)
        ).rstrip()
        for row in cells
    ]
    lines.insert(1, "  ".join("-" * width for width in widths))
    return "\n".join(lines)


def _text(entry: object) -> str:
    if entry is None:
        return ""
    if isinstance(entry, float):
        return number(entry)
    return str(entry)


def number(value: float) -> str:
    """Four significant digits, without needless zeros or exponents."""
    if value != value:
        return "-"
    return f"{value:.4g}"
