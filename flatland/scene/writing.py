"""Scenes as TOML text."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from flatland.scene.model import Scene

_TEMPLATE = """\
# A scene: what is there. How it is computed is chosen when it is run.
# Lengths are in metres, fluxes in watts; x points right, y up.

title = "My scene"

[grid]
shape = [32, 32]        # cells along x, y
spacing = 1.0           # side of a cell
# origin = [0.0, 0.0]   # lower corner of the grid

# A segment that emits to the left of start -> end. On a cell border its light starts in the
# middle of the cell in front of it.
[[light]]
kind = "area"
start = [8.0, 2.0]
end = [24.0, 2.0]
flux = 16.0             # or radiance = ...; for colours a list: flux = [16.0, 8.0, 4.0]

# More kinds of light; take the # away to use them.
# [[light]]
# kind = "cell"
# cell = [4, 20]        # counted from 0
# direction = [1.0, 0.0]  # without it the light is the same in all directions
# flux = 1.0
#
# [[light]]
# kind = "wall"
# side = "left"         # left, right, bottom, top
# flux = 8.0            # of the whole side
# first = 8             # part of the side, cells counted from 0
# last = 23
#
# [[light]]
# kind = "point"        # shines in all directions, and off the walls
# position = [4.5, 24.5]
# flux = 4.0
# inject = "both"       # or "direct", its own light, or "bounce", what walls send back
#
# [[light]]
# kind = "directional"  # parallel light from outside, and what walls send back
# direction = [1.0, -2.0]
# irradiance = 0.5      # per metre across the light
#
# [[light]]
# kind = "environment"  # the same from every direction outside
# radiance = 0.1
#
# [[light]]
# kind = "file"
# file = "light.npz"    # array "coefficients" of shape (2 n - 1, 32, 32) for n bands
# multiplier = 1.0

# A thin wall, opaque from both sides.
[[occluder]]
kind = "segment"
start = [4.0, 16.0]
end = [20.0, 16.0]
albedo = 0.0            # reflected share, 0 is black

# [[occluder]]
# kind = "polygon"
# vertices = [[22.0, 18.0], [28.0, 18.0], [25.0, 24.0]]
#
# [[occluder]]
# kind = "circle"
# center = [10.0, 26.0]
# radius = 3.0
"""


def scene_template() -> str:
    """A commented scene file to start from; it loads as it is."""
    return _TEMPLATE


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
