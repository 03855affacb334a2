"""The columns of kind `errors`."""

from __future__ import annotations

from studies.comparison import MEANINGS
from studies.kinds.base import SCHEME_COLUMNS, Column

COLUMNS: dict[str, Column] = {
    "scene": Column(str, "name of the scene"),
    "scene_digest": Column(str, "fingerprint of the scene on this grid"),
    "dimension": Column(int, "of the grid"),
    "resolution": Column(int, "cells per cell of the scene, along each axis"),
    "cells": Column(int, "cells along the longest side, N"),
    "spacing": Column(float, "side of a cell", "m"),
    **SCHEME_COLUMNS,
    "precision": Column(str, "of the stepped fields"),
    "blocking": Column(str, "what walls do"),
    "strength": Column(float, "factor on fuzzy blocking"),
    "bounces": Column(bool, "whether walls send light back"),
    "lights_block": Column(bool, "whether area lights are walls for other light"),
    "stop": Column(str, "steps, converged or direct"),
    "iterations": Column(int, "steps done"),
    "heuristic": Column(bool, "whether that is the paper's 2 N"),
    "converge": Column(float, "relative residual asked for"),
    "residual": Column(float, "relative residual reached"),
    "solver": Column(str, "what reached it"),
    "applications": Column(int, "how often the solver applied the operator"),
    **{name: Column(float, meaning) for name, meaning in MEANINGS.items()},
    "band_errors": Column(list, "relative L2 of each band's coefficients"),
    "drift": Column(float, "flux made (+) or lost (-) by the scheme over flux emitted"),
    **{
        name: Column(float, f"flux {name}, all colours", "W")
        for name in ("emitted", "left", "absorbed", "inside", "created", "reflected", "closure")
    },
    "seconds": Column(float, "stepping or solving; the median if timed", "s"),
    "seconds_low": Column(float, "lower quartile of the timed runs", "s"),
    "seconds_high": Column(float, "upper quartile of the timed runs", "s"),
    "repeats": Column(int, "timed runs; 0: one run, with others beside it"),
    "first_seconds": Column(float, "the first run, which also compiles", "s"),
    "setup_seconds": Column(float, "stencil, blocking and memory, before the first run", "s"),
    "command": Column(str, "what computes the row again"),
}
