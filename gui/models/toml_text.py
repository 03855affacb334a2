"""Edits of a scene's TOML text that leave comments and formatting alone.

Every edit is checked: the new text must read as the tables that were meant. Where the gentle way
fails (tables in an order that no tool keeps), the scene is written anew and comments are lost.
"""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from flatland.scene.lines import key_lines
from flatland.scene.writing import tables_to_toml

#: Marks a key that is to go.
REMOVED = object()
Tables = dict[str, Any]


def tables_of(text: str) -> Tables:
    """The tables of a text that is valid TOML."""
    return tomllib.loads(text)


def update_table(text: str, path: tuple[str | int, ...], changes: Mapping[str, Any]) -> str:
    """Set or remove keys of the table at a path such as ("grid",) or ("light", 0)."""
    return update_tables(text, {path: changes})


def update_tables(text: str, edits: Mapping[tuple[str | int, ...], Mapping[str, Any]]) -> str:
    """Set or remove keys of several tables, by their paths."""
    wanted = tables_of(text)
    real: dict[tuple[str | int, ...], dict[str, Any]] = {}
    for path, changes in edits.items():
        table = _at(wanted, path)
        real[path] = {key: value for key, value in changes.items() if _differs(table, key, value)}
        _set(table, real[path])
    if not any(real.values()):
        return text

    def gently() -> str:
        document = tomlkit.parse(text)
        for path, changes in real.items():
            place = _at(document, path)
            for key, value in changes.items():
                _write(place, key, value)
        return tomlkit.dumps(document)

    return _checked(gently, wanted)


def insert_tables(text: str, key: str, tables: Sequence[Mapping[str, Any]]) -> str:
    """Append tables to the list [[key]]: after its last one, or at the end of the text."""
    wanted = tables_of(text)
    wanted.setdefault(key, [])
    wanted[key] = [*wanted[key], *map(dict, tables)]
    block = tables_to_toml({key: list(tables)})

    def gently() -> str:
        lines = text.splitlines(keepends=True)
        spans = table_spans(text)
        mine = [stop for (name, _), (_, stop) in spans.items() if name == key]
        at = max(mine) if mine else len(lines)
        before, after = "".join(lines[:at]).rstrip("\n"), "".join(lines[at:]).lstrip("\n")
        parts = [before, block.rstrip("\n"), after]
        return "\n\n".join(part for part in parts if part).rstrip("\n") + "\n"

    return _checked(gently, wanted)


def remove_tables(text: str, places: Sequence[tuple[str, int]]) -> str:
    """Remove tables of lists, with the comments right above them."""
    wanted = tables_of(text)
    for key in {name for name, _ in places}:
        gone = {index for name, index in places if name == key}
        wanted[key] = [table for i, table in enumerate(wanted[key]) if i not in gone]
        if not wanted[key]:
            del wanted[key]

    def gently() -> str:
        lines, spans = text.splitlines(keepends=True), table_spans(text)
        for place in sorted(places, key=lambda each: spans[each], reverse=True):
            start, stop = spans[place]
            del lines[start:stop]
        return "".join(lines).rstrip("\n") + "\n"

    return _checked(gently, wanted)


def table_spans(text: str) -> dict[tuple[str, int], tuple[int, int]]:
    """First line and line behind the last of each [[key]] table, comments above it included."""
    lines = text.splitlines()
    heads = {
        (str(path[0]), int(path[1]) - 1): line - 1
        for path, line in key_lines(text).items()
        if len(path) == 2 and isinstance(path[1], int)
    }
    plain = [line - 1 for path, line in key_lines(text).items() if len(path) == 1]
    starts = {line: _above(lines, line) for line in {*heads.values(), *plain}}
    borders = sorted({*starts.values(), len(lines)})
    return {
        place: (starts[line], min(b for b in borders if b > line)) for place, line in heads.items()
    }


def _above(lines: Sequence[str], line: int) -> int:
    """First line of the comment block that ends right above a line."""
    while line > 0 and lines[line - 1].lstrip().startswith("#"):
        line -= 1
    return line


def _checked(gently: Any, wanted: Tables) -> str:
    try:
        text = gently()
        if tomllib.loads(text) == wanted:
            return str(text)
    except (TOMLKitError, LookupError, TypeError, ValueError, AttributeError):
        pass  # told apart below: the text says something else, or nothing at all
    return tables_to_toml(wanted)


def _at(tables: Any, path: tuple[str | int, ...]) -> Any:
    for part in path:
        tables = tables[part]
    return tables


def _differs(table: Mapping[str, Any], key: str, value: Any) -> bool:
    return key in table if value is REMOVED else table.get(key, REMOVED) != plain(value)


def _set(table: Any, changes: Mapping[str, Any]) -> None:
    for key, value in changes.items():
        if value is REMOVED:
            del table[key]
        else:
            table[key] = plain(value)


def _write(place: Any, key: str, value: Any) -> None:
    """Into a tomlkit table: a changed value keeps the comment behind it, a new key follows the
    last one, before comments that speak of what comes next."""
    if value is REMOVED:
        del place[key]
        return
    item = tomlkit.item(plain(value))
    if key in place:
        trivia = place[key].trivia
        item.trivia.comment_ws, item.trivia.comment = trivia.comment_ws, trivia.comment
        place[key] = item
    elif body := list(place.keys()):
        place.value._insert_after(body[-1], key, item)
    else:
        place[key] = item


def plain(value: Any) -> Any:
    """Tuples as lists, as TOML has them."""
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return copy.copy(value) if isinstance(value, dict) else value
