"""The scenes of a study: by name, on a grid as fine as wanted, with a fingerprint."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from flatland.errors import InputError, bad_input
from flatland.scene import Scene, builtin_names, load_scene, refined

#: Names that stand for all built-in scenes of a dimension, so that new ones join.
ALL = {"all-2d": 2, "all-3d": 3}


@dataclass(frozen=True)
class StudyScene:
    """One scene on one grid, as plain values that can travel to a worker.

    name: as it was asked for. resolution: how many of the scene's cells along each axis stand for
    one of the file's. tables: the scene on that grid. directory: where its data files are. word:
    what the command line calls the scene; the study's own are files among its results.
    """

    name: str
    resolution: int
    tables: Mapping[str, Any]
    directory: str = ""
    word: str = ""

    def load(self) -> Scene:
        return _load(json.dumps([self.tables, self.directory], default=list))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that the scene holds, data files included; its name does not count."""
        content = hashlib.sha256(json.dumps(self.tables, sort_keys=True, default=list).encode())
        for file in data_files(self.tables):
            content.update((Path(self.directory) / file).read_bytes())
        return content.hexdigest()

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "resolution": self.resolution,
            "tables": self.tables,
            "directory": self.directory,
            "word": self.word,
        }


def study_scenes(
    names: list[str], resolution: int, inline: Mapping[str, Mapping[str, Any]]
) -> list[StudyScene]:
    """The scenes of those names: of the study itself, built in, or files; `all-2d` is several.

    Raises InputError for unknown ones and for those that have no such resolution.
    """
    chosen = [each for name in names for each in _expanded(name)]
    return [_study_scene(name, resolution, inline) for name in dict.fromkeys(chosen)]


def data_files(tables: Mapping[str, Any]) -> list[str]:
    """Names of the files that a scene's lights and occluders read, sorted."""
    items = [*tables.get("light", ()), *tables.get("occluder", ())]
    return sorted({item["file"] for item in items if "file" in item})


def _expanded(name: str) -> list[str]:
    if name not in ALL:
        return [name]
    return [each for each in builtin_names() if load_scene(each).grid.dimension == ALL[name]]


def _study_scene(name: str, resolution: int, inline: Mapping[str, Mapping[str, Any]]) -> StudyScene:
    if not isinstance(name, str):
        raise bad_input("scenes", name, "must be names of scenes or paths of files")
    directory, word = "", name
    if name in inline:
        scene, word = Scene.from_dict(inline[name], f"scene {name}"), f"scenes/{name}.toml"
    else:
        scene = load_scene(name)
        if name.partition(":")[0] not in builtin_names():
            path = Path(name).absolute()
            directory, word = str(path.parent), str(path)
    try:
        tables = refined(scene, resolution).to_dict()
    except InputError as error:
        rule = f"scene {name!r} has no such resolution: {error}"
        raise bad_input("resolution", resolution, rule) from None
    plain = json.loads(json.dumps(tables, default=list))
    return StudyScene(name, resolution, plain, directory, word)


@lru_cache(maxsize=8)
def _load(text: str) -> Scene:
    tables, directory = json.loads(text)
    return Scene.from_dict(tables, directory=directory)
