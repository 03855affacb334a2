"""Docstrings as they are written here, plain prose with `code` in backticks, for autodoc."""

from __future__ import annotations

import inspect
import re
from collections.abc import Sequence
from typing import Any

from sphinx.application import Sphinx

_CODE = re.compile(r"(``?)([^`\n]+)\1")
_SPECIAL = re.compile(r"([*|\\]|(?<=\w)_(?=\W|$))")
_NUMERICS = re.compile(r"\(?numerics §(\d+)\)?")
_FAULTS = re.compile(r"\b(What it gets wrong):")
#: Names that docstrings speak of without backticks, and where they are explained.
_KNOWN = {
    **{
        name: f"flatland.{name}"
        for name in ("InputError", "InstabilityError", "ConvergenceError", "SchemeWarning")
    },
    "FlatlandError": "flatland.FlatlandError",
    "ResultFileError": "flatland.errors.ResultFileError",
    "SceneError": "flatland.scene.SceneError",
    "LevelRules": "flatland.octree.rules.LevelRules",
}
_NAMES = re.compile(rf"\b({'|'.join(_KNOWN)})\b")


def setup(app: Sphinx) -> dict[str, bool]:
    """Read docstrings after autodoc found them."""
    app.connect("autodoc-process-docstring", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _read(app: Sphinx, what: str, name: str, given: Any, options: Any, lines: list[str]) -> None:
    arguments = _arguments(given)
    drawing = False  # after "::", indented lines are shown as they are
    for number, line in enumerate(lines):
        if line.strip() and not line.startswith(" "):
            drawing = False
        if not drawing:
            lines[number] = restructured(line, arguments)
        drawing = drawing or line.rstrip().endswith("::")


def _arguments(given: Any) -> list[str]:
    """Names that a docstring may explain as `name: meaning`."""
    try:
        parameters = list(inspect.signature(given).parameters)
    except (TypeError, ValueError):
        parameters = []
    return [*parameters, *getattr(given, "__annotations__", {})]


def restructured(line: str, arguments: Sequence[str] = ()) -> str:
    """One line of prose as reStructuredText: code in backticks, nothing else with a meaning."""
    if arguments:
        names = "|".join(map(re.escape, arguments))
        line = re.sub(rf"(^\s*|[.;:] |, )({names}): ", r"\1`\2`: ", line)
    parts, end = [], 0
    for match in _CODE.finditer(line):
        parts += [_plain(line[end : match.start()]), f"``{match[2]}``"]
        end = match.end()
    return "".join([*parts, _plain(line[end:])])


def _plain(text: str) -> str:
    escaped = _SPECIAL.sub(r"\\\1", text)
    escaped = _NUMERICS.sub(_link, escaped)
    escaped = _NAMES.sub(lambda found: f":py:obj:`{found[1]} <{_KNOWN[found[1]]}>`", escaped)
    return _FAULTS.sub(r"**\1:**", escaped)


def _link(found: re.Match[str]) -> str:
    link = f":doc:`numerics §{found[1]} </numerics>`"
    opened, closed = found[0].startswith("("), found[0].endswith(")")
    return f"{'(' if opened else ''}{link}{')' if closed else ''}"
