"""The command line that computes a row of a study again."""

from __future__ import annotations

import shlex
from typing import Any

from propagators import Propagator, StencilPropagator
from studies.kinds.base import scheme_of
from studies.kinds.stopping import AXES
from studies.sweeps.case import Case


def command_of(case: Case, iterations: int | None = None) -> str:
    """The command line that computes a row again and prints its errors."""
    assert case.scene is not None
    values, scheme = case.parameters, scheme_of(case.parameters)
    words: list[Any] = ["flatland", "run", shlex.quote(case.scene.word)]
    if case.scene.resolution > 1:
        words += ["--resolution", case.scene.resolution]
    words += ["--propagator", scheme.name, *_option_words(scheme), "--bands", values["bands"]]
    if isinstance(scheme, StencilPropagator):
        words += _stencil_words(values, iterations)
    words += ["--reference"] if values["reference"] else []
    return " ".join(map(str, words))


def _stencil_words(values: Any, iterations: int | None) -> list[Any]:
    words: list[Any] = ["--iterations", iterations] if iterations is not None else []
    if values["converge"]:
        words += ["--converge", values["converge"]]
    for axis in AXES:
        value = values.get(axis.name)
        if axis.name in ("precision", "blocking", "strength") and value != axis.default:
            words += [f"--{axis.name}", value]
    words += [] if values["bounces"] else ["--no-bounces"]
    return words + (["--lights-block"] if values["lights_block"] else [])


def _option_words(scheme: Propagator) -> list[str]:
    words = []
    for option in scheme.options:
        if scheme.values[option.name] != option.default:
            words += ["--option", f"{option.name}={scheme.values[option.name]}"]
    return words
