"""Methods on scenes, for figures that compare them: fields, errors, and the commands for them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from flatland.field import Field
from flatland.results import versions
from flatland.scene import Scene, load_scene, refined, scene_to_toml
from propagators import create
from studies.metrics import relative_l2
from studies.reference import Reference
from studies.running import Method, run_method

#: Relative residual to which stencils are converged.
CONVERGED = 1e-8


class Asked(NamedTuple):
    """One method on one scene, with cells cut `resolution` times along each axis."""

    scene: str
    propagator: str
    options: Mapping[str, Any] = {}
    bands: int = 2
    resolution: int = 1

    @property
    def command(self) -> str:
        """The command line that gives the field again, with its errors."""
        words: list[Any] = ["flatland", "run", self.scene]
        words += ["--resolution", self.resolution] if self.resolution > 1 else []
        words += ["--propagator", self.propagator]
        for name, value in self.options.items():
            words += ["--option", f"{name}={value}"]
        words += ["--bands", self.bands]
        words += ["--converge", CONVERGED] if self._steps else []
        return " ".join(map(str, [*words, "--reference"]))

    @property
    def _steps(self) -> bool:
        from propagators import StencilPropagator, find

        return issubclass(find(self.propagator), StencilPropagator)

    def field(self, scene: Scene) -> Field:
        propagator = create(self.propagator, **self.options)
        converge = CONVERGED if self._steps else None
        return run_method(scene, Method(propagator, self.bands, converge=converge)).accumulated


class Answers:
    """Fields of methods and the exact ones beside them, each scene's exact answer found once."""

    def __init__(self) -> None:
        self._references: dict[tuple[str, int], Reference] = {}

    def scene(self, asked: Asked) -> Scene:
        return self._reference(asked).scene

    def exact(self, asked: Asked) -> Field:
        return self._reference(asked).field(asked.bands)

    def _reference(self, asked: Asked) -> Reference:
        key = asked.scene, asked.resolution
        if key not in self._references:
            scene = load_scene(asked.scene)
            cut = scene if asked.resolution == 1 else refined(scene, asked.resolution)
            self._references[key] = Reference(cut)
        return self._references[key]

    def error(self, asked: Asked) -> float:
        """Relative L2 error of all coefficients."""
        return relative_l2(asked.field(self.scene(asked)), self.exact(asked))

    def rows(self, asked: Sequence[Asked], **columns: Sequence[Any]) -> xr.Dataset:
        """One row for each: what was asked, its error, its command; and further columns."""
        rows = xr.Dataset(
            {
                "scene": ("row", [each.scene for each in asked]),
                "propagator": ("row", [each.propagator for each in asked]),
                "options": ("row", [json.dumps(dict(each.options)) for each in asked]),
                "bands": ("row", [each.bands for each in asked]),
                "resolution": ("row", [each.resolution for each in asked]),
                "error": ("row", [self.error(each) for each in asked]),
                "command": ("row", [each.command for each in asked]),
            }
        )
        rows["error"].attrs["long_name"] = "relative L2 error of all coefficients"
        for name, values in columns.items():
            rows[name] = ("row", np.asarray(values))
        names = dict.fromkeys(each.scene for each in asked)
        rows.attrs["scenes"] = json.dumps({n: scene_to_toml(load_scene(n)) for n in names})
        rows.attrs["versions"] = json.dumps(versions(), sort_keys=True)
        return rows
