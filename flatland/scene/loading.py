"""Scenes from files, from text, and by name."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from flatland.scene.catalogue import BUILTIN_DIRECTORY, builtin_names, builtin_text, is_builtin
from flatland.scene.lines import key_lines
from flatland.scene.model import Scene
from flatland.scene.problems import SceneError, scene_error, suggestion

#: Scene files larger than this are something else.
LARGEST_FILE = 64 * 2**20


def load_scene(name_or_path: str | os.PathLike[str]) -> Scene:
    """A built-in scene by name, such as "shelf" or "clutter:size=128", or a scene file.

    A built-in name wins over a file of the same name: write ./shelf for the file.
    Raises SceneError with every mistake that was found.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise scene_error(name_or_path, "must be a name or a path", "load_scene")
    name = os.fsdecode(name_or_path)
    if isinstance(name_or_path, str) and is_builtin(name):
        return parse_scene(builtin_text(name), f"built-in scene {name}", BUILTIN_DIRECTORY)
    path = Path(name)
    return parse_scene(_read(path), str(path), path.parent)


def parse_scene(
    text: str | bytes, source_name: str = "scene", directory: str | os.PathLike[str] = ""
) -> Scene:
    """A scene from TOML text, or from bytes in UTF-8.

    source_name: what messages call the text. directory: where file names in it start.
    Raises SceneError with every mistake that was found.
    """
    decoded = _decode(text, source_name)
    data = _tables(decoded, source_name)
    if not data:
        rule = "is empty; a scene needs at least a [grid] table with a shape"
        raise scene_error(decoded, rule, source_name)
    try:
        return Scene.from_dict(data, source_name, directory)
    except SceneError as error:
        raise error.with_lines(key_lines(decoded)) from None


def _read(path: Path) -> bytes:
    """The file's bytes; never more than LARGEST_FILE of them."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except (FileNotFoundError, NotADirectoryError):
        names = builtin_names()
        rule = f"is neither a file nor a built-in scene{suggestion(str(path), names)}"
        rule += "; built in: " + ", ".join(names)
        raise scene_error(str(path), rule, "load_scene") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        rule = f"cannot be read ({reason})"
        raise scene_error(str(path), rule, "load_scene") from None
    if len(content) > LARGEST_FILE:
        rule = f"is larger than the {LARGEST_FILE >> 20} MiB that a scene file may have"
        raise scene_error(str(path), rule, "load_scene")
    return content


def _decode(text: str | bytes, source: str) -> str:
    if isinstance(text, str):
        return text.removeprefix("\ufeff")
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = text[error.start : error.start + 8]
        line = text.count(b"\n", 0, error.start) + 1
        rule = "is not UTF-8 text, as scene files are"
        raise scene_error(found, rule, source, "bytes", line) from None


def _tables(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(str(error), text, source) from None
    except (ValueError, RecursionError) as error:  # a number of 5000 digits, a deep nest
        rule = f"cannot be read as TOML ({error})"
        raise scene_error(text[:100], rule, source) from None


def _syntax_error(message: str, text: str, source: str) -> SceneError:
    """tomllib's message with the line it speaks of."""
    found = re.search(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    lines = text.split("\n")
    line = int(found[1]) if found and found[1] else len(lines)
    reason = message[: found.start()] if found else message
    where = f", column {found[2]}" if found and found[2] else ""
    rule = f"is not valid TOML: {reason}{where}"
    return scene_error(lines[line - 1].strip(), rule, source, "text", line)
