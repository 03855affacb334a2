"""The chosen method: what the window's controls say, as a value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from flatland.errors import bad_input
from flatland.scene import Scene
from gui.models.levels import LEVEL_OPTIONS
from propagators import StencilPropagator, create
from propagators.base import Option
from propagators.registry import find, names
from studies.running import Method

BLOCKING = ("exact", "fuzzy", "none")
PRECISION = ("float64", "float32")
#: Bands that the window offers; scenes in 3D hold the square of it per cell.
MOST_BANDS = 64


@dataclass(frozen=True)
class Choice:
    """A method as plain values; the same words as the options of `flatland run`."""

    propagator: str = "lpv"
    options: Mapping[str, Any] = field(default_factory=dict)
    bands: int = 4
    levels: int = 1
    octree: Mapping[str, Any] = field(default_factory=dict)
    precision: str = "float64"
    blocking: str = "exact"
    strength: float = 1.0
    bounces: bool = True
    lights_block: bool = False

    def method(self, iterations: int | None = None, converge: float | None = None) -> Method:
        """The method to run. Raises InputError for values that break a rule."""
        if not 1 <= self.bands <= MOST_BANDS:
            raise bad_input("bands", self.bands, f"must be from 1 to {MOST_BANDS}")
        values: dict[str, Any] = {
            "propagator": create(self.propagator, **self.options),
            "bands": self.bands,
            "iterations": iterations,
            "converge": converge,
            "precision": self.precision,
            "blocking": self.blocking,
            "strength": self.strength,
            "bounces": self.bounces,
            "lights_block": self.lights_block,
        }
        values["levels"] = self.levels if self.steps else 1
        for option in level_options():
            given = self.octree.get(option.name, option.default)
            values[option.name] = option.check(given)
        return Method(**values)

    @property
    def steps(self) -> bool:
        """Whether the propagator can be stepped; others answer directly."""
        return issubclass(find(self.propagator), StencilPropagator)

    def fitting(self, scene: Scene) -> Choice:
        """The same choice if its propagator works in the scene's dimension, else the first that
        does."""
        if scene.grid.dimension in find(self.propagator).dimensions:
            return self
        return replace(self, propagator=propagators_for(scene.grid.dimension)[0], options={})

    @property
    def label(self) -> str:
        """Short name for legends."""
        changed = ", ".join(f"{key}={value}" for key, value in self._changed_options().items())
        levels = f", {self.levels} levels" if self.levels > 1 else ""
        scheme = f"{self.propagator}({changed})" if changed else self.propagator
        return f"{scheme}, {self.bands} bands{levels}"

    def arguments(self) -> list[str]:
        """Words of `flatland run` that choose this method; defaults of the command left out."""
        words = ["--propagator", self.propagator]
        for key, value in self._changed_options().items():
            words += ["--option", f"{key}={_word(value)}"]
        words += ["--bands", str(self.bands)]
        if self.levels != 1 and self.steps:
            words += ["--levels", str(self.levels)]
            for option in level_options():
                value = self.octree.get(option.name, option.default)
                if value != option.default:
                    words += [f"--{option.name}", _word(value)]
        for name in ("precision", "blocking", "strength"):
            value = getattr(self, name)
            if value != getattr(Choice, name):
                words += [f"--{name}", _word(value)]
        words += [] if self.bounces else ["--no-bounces"]
        return words + (["--lights-block"] if self.lights_block else [])

    def _changed_options(self) -> dict[str, Any]:
        defaults = {option.name: option.default for option in find(self.propagator).options}
        return {key: value for key, value in self.options.items() if value != defaults.get(key)}


def level_options() -> list[Option]:
    """Options of an octree that methods of this version know."""
    return list(LEVEL_OPTIONS)


def propagators_for(dimension: int) -> list[str]:
    """Names of the propagators that work in a dimension, those that can be stepped first."""
    working = [name for name in _loadable() if dimension in find(name).dimensions]
    return sorted(working, key=lambda name: not issubclass(find(name), StencilPropagator))


def _loadable() -> list[str]:
    """Names without broken plug-ins: one bad package must not close the window."""
    good = []
    for name in names():
        try:
            find(name)
        except ValueError:
            continue
        good.append(name)
    return good


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.17g}" if isinstance(value, float) else str(value)
