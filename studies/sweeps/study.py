"""A study: which cases there are, declared as data."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from flatland.errors import InputError, bad_input
from flatland.scene.writing import tables_to_toml
from studies.kinds import find_kind
from studies.sweeps.case import Case

BUILTIN_DIRECTORY = Path(__file__).parent.parent / "builtin"


@dataclass(frozen=True)
class Study:
    """Sweeps over schemes, scenes and settings; their cases, taken together, are the study.

    sweeps: tables as in a file, each with a `kind` ("errors" if not given); a key may hold one
    value or a list, and the sweep is the product of all lists. scenes: the study's own scenes by
    name, tables as in a scene file. Raises InputError for anything that is not understood, when
    the cases are asked for.
    """

    name: str
    title: str = ""
    sweeps: tuple[Mapping[str, Any], ...] = ()
    scenes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def cases(self) -> list[Case]:
        """Every case once, in the order declared."""
        if not self.sweeps:
            raise bad_input("study", self.name, "has no [[sweep]]")
        found: dict[str, Case] = {}
        for number, table in enumerate(self.sweeps, 1):
            try:
                cases = self._expanded(table)
            except InputError as error:
                raise InputError(f"study {self.name}, sweep {number}: {error}") from None
            for case in cases:
                found.setdefault(case.key, case)
        return list(found.values())

    def _expanded(self, table: Mapping[str, Any]) -> list[Case]:
        rest = {key: value for key, value in table.items() if key != "kind"}
        return find_kind(table.get("kind", "errors")).expand(rest, self.scenes)

    def with_values(self, values: Mapping[str, Any]) -> Study:
        """The study with some keys of its sweeps replaced, in every sweep that has the key.

        Raises InputError for a key that no sweep has.
        """
        known = {key for table in self.sweeps for key in table}
        for key in values:
            if key not in known:
                raise bad_input("--set", key, "is a key of no sweep of this study", sorted(known))
        sweeps = tuple(
            {**table, **{key: value for key, value in values.items() if key in table}}
            for table in self.sweeps
        )
        return replace(self, sweeps=sweeps)

    def to_toml(self) -> str:
        """The study as a file: parse_study(study.to_toml(), study.name) == study."""
        tables: dict[str, Any] = {"title": self.title, "sweep": list(self.sweeps)}
        return tables_to_toml({**tables, "scene": self.scenes} if self.scenes else tables)


def load_study(name_or_path: str) -> Study:
    """A built-in study by name, or a TOML file. Raises InputError."""
    if name_or_path in builtin_studies():
        path = BUILTIN_DIRECTORY / f"{name_or_path}.toml"
    else:
        path = Path(name_or_path)
    try:
        text = path.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        rule = "is neither a file nor a built-in study"
        raise bad_input("study", name_or_path, rule, builtin_studies()) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise bad_input("study", name_or_path, f"cannot be read ({reason})") from None
    return parse_study(text, path.stem)


def parse_study(text: str, name: str) -> Study:
    """A study from TOML: title, [[sweep]] tables, and scenes as [scene.NAME]. Raises InputError."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise bad_input("study", name, f"is not valid TOML: {error}") from None
    for key in tables:
        if key not in ("title", "sweep", "scene"):
            rule = "is an unknown key of a study"
            raise bad_input("study", key, rule, ("title", "sweep", "scene"))
    sweeps, scenes = tables.get("sweep", []), tables.get("scene", {})
    if not isinstance(sweeps, list) or not all(isinstance(table, dict) for table in sweeps):
        raise bad_input("sweep", sweeps, "must be tables, each begun with [[sweep]]")
    if not isinstance(scenes, dict) or not all(
        isinstance(table, dict) for table in scenes.values()
    ):
        raise bad_input("scene", scenes, "must be tables, each begun with [scene.NAME]")
    title = tables.get("title", "")
    if not isinstance(title, str):
        raise bad_input("title", title, "must be text")
    return Study(name, title, tuple(sweeps), scenes)


def builtin_studies() -> list[str]:
    """Names of the built-in studies, sorted."""
    return sorted(path.stem for path in BUILTIN_DIRECTORY.glob("*.toml"))
