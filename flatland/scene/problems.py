"""Mistakes of a scene, said in one voice and all at once."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from flatland.errors import InputError, bad_input
from flatland.injectors import INJECTORS
from flatland.injectors.values import AS_GIVEN, Broken
from flatland.occluders import OCCLUDERS

#: Mistakes named in a message; the rest are counted.
MOST_SHOWN = 20
#: Findings about a key that is told with its table, as the key itself has no value to show.
ABOUT_TABLE = ("missing", "invalid_key")
REGISTRIES: dict[str, dict[str, Any]] = {"light": INJECTORS, "occluder": OCCLUDERS}


@dataclass(frozen=True)
class Problem:
    """One mistake. key: where it is, as ("light", 1, "start"), tables counted from 1.

    text: the whole story but for the file. line: its line in the file, if it was found.
    """

    text: str
    source: str
    key: tuple[str | int, ...] = ()
    line: int | None = None

    def __str__(self) -> str:
        return f"{self.source}{f', line {self.line}' if self.line else ''}: {self.text}"


class SceneError(InputError):
    """A scene breaks rules; `problems` holds all of them, the message says them one a line."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = list(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        lines = [str(problem) for problem in self.problems[:MOST_SHOWN]]
        if hidden := len(self.problems) - MOST_SHOWN:
            lines += [f"... and {hidden} more mistakes"] if hidden > 0 else []
        return "\n".join(lines)

    def with_lines(self, lines: dict[tuple[str | int, ...], int]) -> SceneError:
        """The same mistakes, with the line of the key or, failing that, of its table."""
        return SceneError(
            replace(p, line=lines.get(p.key) or lines.get(p.key[:-1])) for p in self.problems
        )


def scene_error(
    value: Any, rule: str, source: str, argument: str = "scene", line: int | None = None
) -> SceneError:
    """The error for a scene that could not even be read as tables."""
    text = str(bad_input(argument, Shown(value), rule))
    return SceneError([Problem(text, source, line=line)])


def problems_in(error: ValidationError, scene: type[BaseModel], source: str) -> list[Problem]:
    """Every mistake that validation found, in the order of the scene's tables."""
    details = error.errors(include_url=False)
    return [problem for detail in details for problem in _problems(detail, scene, source)]


class Shown:
    """A value as an error shows it, whatever it is: its own repr may fail or be huge."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __repr__(self) -> str:
        try:
            return repr(_lists(self.value))
        except (ValueError, RecursionError):  # an integer of 5000 digits, a deep nest
            return f"<{type(self.value).__name__} too long to show>"


def _lists(value: Any) -> Any:
    """Tuples as lists: scene files know no tuples."""
    return [_lists(entry) for entry in value] if isinstance(value, tuple) else value


def _problems(detail: ErrorDetails, scene: type[BaseModel], source: str) -> Iterable[Problem]:
    path = list(detail["loc"])
    table: Any = scene
    if path and path[0] in REGISTRIES and len(path) > 1:
        path[1] = int(path[1]) + 1
        if len(path) > 2:  # pydantic puts the kind between the table and the key
            table = REGISTRIES[str(path[0])][str(path.pop(2))]
    elif len(path) > 1:
        tables = {field.alias: field.annotation for field in scene.model_fields.values()}
        table = tables.get(str(path[0]), scene)
    for broken in _broken_rules(detail, table):
        key = (*path, *_parts(broken.key)) if broken.key else tuple(path)
        value = detail["input"] if broken.value is AS_GIVEN else broken.value
        about = key[:-1] if detail["type"] in ABOUT_TABLE else key
        refused = bad_input(_place(about), Shown(value), broken.rule, broken.choices)
        yield Problem(str(refused), source, key)


def _parts(key: str) -> list[str | int]:
    """ "light, 1, start" as ["light", 1, "start"]."""
    return [int(part) if part.isdecimal() else part for part in key.split(", ")]


def _broken_rules(detail: ErrorDetails, table: type[BaseModel]) -> Sequence[Broken]:
    kind, loc, context = detail["type"], detail["loc"], detail.get("ctx", {})
    if kind == "broken_rules":
        return context["broken"]
    if kind == "missing":
        return [Broken(f"has no key {loc[-1]!r}, which it needs")]
    if kind == "extra_forbidden":
        return [
            _unknown(str(loc[-1]), "key", [f.alias or n for n, f in table.model_fields.items()])
        ]
    if kind == "literal_error":
        return [Broken("is none of the choices", (context["expected"],))]
    if kind == "union_tag_invalid":
        given, kinds = detail["input"]["kind"], list(REGISTRIES[str(loc[0])])
        return [replace(_unknown(str(given), "kind", kinds), key="kind", value=given)]
    if kind == "union_tag_not_found":
        return [Broken("has no key 'kind'", tuple(REGISTRIES[str(loc[0])]))]
    if kind == "invalid_key":
        return [Broken("has a key that is not text")]
    if kind == "bool_type":
        return [Broken("must be true or false")]
    if kind == "tuple_type":
        return [Broken(f"must be a list of tables, each begun with [[{loc[0]}]]")]
    return [Broken("must be a table")]


def _unknown(word: str, what: str, accepted: Sequence[str]) -> Broken:
    return Broken(f"is an unknown {what}{suggestion(word, accepted)}", tuple(accepted))


def suggestion(word: str, accepted: Sequence[str]) -> str:
    """ "; did you mean ..." if an accepted word is close, else nothing."""
    close = difflib.get_close_matches(word[:100], accepted, n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def _place(key: tuple[str | int, ...]) -> str:
    """("light", 1, "start") as "light 1, start"."""
    place = ""
    for part in key:
        place += f" {part}" if isinstance(part, int) else f"{', ' if place else ''}{part}"
    return place or "scene"
