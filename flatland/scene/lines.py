"""Where a key stands in the text of a scene file."""

from __future__ import annotations

import re
from collections import Counter

_HEADER = re.compile(r"""\s*\[{1,2}\s*["']?([\w-]+)["']?\s*\]{1,2}\s*(#.*)?$""")
_KEY = re.compile(r"""\s*["']?([\w-]+)["']?\s*[=.]""")


def key_lines(text: str) -> dict[tuple[str | int, ...], int]:
    """Line of every key and table, by paths such as ("grid", "shape") or ("light", 1, "flux").

    A scan for lines that look like [table], [[table]] and key = ..., not a parser: text inside
    multi-line strings can fool it, and keys of inline tables are not found.
    """
    lines: dict[tuple[str | int, ...], int] = {}
    count: Counter[str] = Counter()
    table: tuple[str | int, ...] = ()
    for number, line in enumerate(text.split("\n"), 1):
        if header := _HEADER.match(line):
            name = header[1]
            count[name] += 1
            table = (name, count[name]) if line.lstrip().startswith("[[") else (name,)
            lines.setdefault(table, number)
            lines.setdefault((name,), number)
        elif key := _KEY.match(line):
            lines.setdefault((*table, key[1]), number)
    return lines
