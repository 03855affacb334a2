"""The built-in scenes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from flatland.scene.clutter import clutter_text
from flatland.scene.problems import scene_error, suggestion

BUILTIN_DIRECTORY = Path(__file__).parent / "builtin"

#: Scenes made by a function of whole numbers: "name:key=1,other=2".
GENERATED: dict[str, Callable[..., str]] = {"clutter": clutter_text}


def builtin_names() -> list[str]:
    """Names that load_scene accepts, sorted."""
    return sorted([*(file.stem for file in BUILTIN_DIRECTORY.glob("*.toml")), *GENERATED])


def is_builtin(name: str) -> bool:
    """Whether a name, with or without parameters, speaks of a built-in scene."""
    return name.partition(":")[0] in builtin_names()


def builtin_text(name: str) -> str:
    """The TOML text of a built-in scene, comments included.

    Raises SceneError for an unknown name and for parameters the scene does not have.
    """
    stem, _, parameters = name.partition(":")
    if stem in GENERATED:
        return GENERATED[stem](**_parameters(name, parameters))
    names = builtin_names()
    if stem not in names:
        rule = f"is no built-in scene{suggestion(stem, names)}; built in: {', '.join(names)}"
        raise scene_error(name, rule, "builtin_text")
    if parameters:
        raise scene_error(name, f"has no parameters; write {stem!r}", "builtin_text")
    return (BUILTIN_DIRECTORY / f"{stem}.toml").read_text(encoding="utf-8")


def _parameters(name: str, text: str) -> dict[str, str]:
    """ "size=128,seed=3" as a dict; what the values mean is the generator's to check."""
    pairs = [part.partition("=") for part in text.split(",")] if text else []
    if not all(separator for _, separator, _ in pairs):
        rule = "must look like name:key=value,key=value"
        raise scene_error(name, rule, "builtin_text")
    return {key.strip(): value.strip() for key, _, value in pairs}
