"""Scenes as TOML text."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from flatland.scene.model import Scene


def scene_to_toml(scene: Scene) -> str:
    """The scene as TOML: parse_scene(scene_to_toml(scene)) == scene.

    Comments of a file it was read from are lost. Names of data files stay as they were written,
    so the text belongs into the same directory.
    """
    return tables_to_toml(scene.to_dict())


def tables_to_toml(tables: Mapping[str, Any]) -> str:
    """TOML of top-level keys, tables and lists of tables, as scenes have them."""
    keys = {key: value for key, value in tables.items() if not _is_tables(value)}
    blocks = [_block(keys)] if keys else []
    for key, value in tables.items():
        if isinstance(value, Mapping):
            blocks.append(f"[{key}]\n{_block(value)}")
        elif _is_tables(value):
            blocks += [f"[[{key}]]\n{_block(table)}" for table in value]
    return "\n".join(blocks)


def _is_tables(value: Any) -> bool:
    entries = value if isinstance(value, list) else [value]
    return all(isinstance(entry, Mapping) for entry in entries)


def _block(table: Mapping[str, Any]) -> str:
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())


def _key(name: str) -> str:
    """A key, in quotes where TOML wants them."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _value(value: Any) -> str:
    """Text, truth value, number, or a list or an inline table of these."""
    if isinstance(value, Mapping):
        pairs = (f"{_key(key)} = {_value(entry)}" for key, entry in value.items())
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, str):
        # JSON escapes all that TOML wants escaped, but for DEL.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)
