"""Light to begin a stability run with: what excites every wave, and what strains arithmetic."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

#: The same light in every study.
SEED = 20100219

Tables = dict[str, Any]


def start_scene(name: str, dimension: int, side: int) -> Tables:
    """The tables of a scene with `side` cells along each axis."""
    return STARTS[name](dimension, side)


def _random(dimension: int, side: int, strength: float = 1.0) -> Tables:
    """A lobe in every cell, directions and fluxes at random: all waves in all bands."""
    rng = np.random.default_rng(SEED)
    shape = (side,) * dimension
    lights = [
        {
            "kind": "cell",
            "cell": list(cell),
            "direction": rng.normal(size=dimension).tolist(),
            "flux": float(strength * rng.uniform(0.1, 1.0)),
        }
        for cell in np.ndindex(*shape)
    ]
    return {"grid": {"shape": list(shape)}, "light": lights}


def _checkerboard(dimension: int, side: int) -> Tables:
    """Every second cell isotropic: the shortest wave, and what it is mixed with."""
    shape = (side,) * dimension
    cells = [cell for cell in np.ndindex(*shape) if sum(cell) % 2 == 0]
    lights = [{"kind": "cell", "cell": list(cell), "flux": 1.0} for cell in cells]
    return {"grid": {"shape": list(shape)}, "light": lights}


def _lobe(dimension: int, side: int) -> Tables:
    """One lobe in the middle."""
    direction = [1.0, 0.4, 0.2][:dimension]
    light = {"kind": "cell", "cell": [side // 2] * dimension, "direction": direction, "flux": 1.0}
    return {"grid": {"shape": [side] * dimension}, "light": [light]}


def _huge(dimension: int, side: int) -> Tables:
    """The random start, 10²⁵ times as bright: near what float32 can hold."""
    return _random(dimension, side, 1e25)


def _tiny(dimension: int, side: int) -> Tables:
    """The random start, 10⁻²⁵ times as bright."""
    return _random(dimension, side, 1e-25)


def _row(dimension: int, side: int) -> Tables:
    """A grid one cell wide."""
    shape = [side] + [1] * (dimension - 1)
    light = {"kind": "cell", "cell": [side // 2] + [0] * (dimension - 1), "flux": 1.0}
    return {"grid": {"shape": shape}, "light": [light]}


def _mirrors(dimension: int, side: int) -> Tables:
    """The random start between perfect mirrors on the border (2D): no light may ever be lost."""
    corners = list(itertools.pairwise([[0, 0], [side, 0], [side, side], [0, side], [0, 0]]))
    walls = [
        {
            "kind": "segment",
            "start": [float(x) for x in start],
            "end": [float(x) for x in end],
            "albedo": 1.0,
        }
        for start, end in corners
    ]
    return {**_random(2, side), "occluder": walls}


#: name: tables from dimension and side.
STARTS: dict[str, Callable[[int, int], Tables]] = {
    "random": _random,
    "checkerboard": _checkerboard,
    "lobe": _lobe,
    "huge": _huge,
    "tiny": _tiny,
    "row": _row,
    "mirrors": _mirrors,
}
