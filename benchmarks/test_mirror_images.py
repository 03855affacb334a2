"""What half of a mirror image saves: steps of lit grids that are folded, and that are not."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable

import pytest

import propagators
from flatland import Scene, Simulation
from studies.tables import table

_SIDES = {2: (128, 256, 512), 3: (24, 32, 64)}
_NAMES = {2: ("lpv", "dom8"), 3: ("lpv", "dom26")}
#: Of one measurement: two batches, before light has left and died.
_STEPS = 32


def _scene(side: int, dimension: int, axes: tuple[int, ...], walled: bool) -> Scene:
    """Cells round the middle that shine, a little off the mirrors of other axes; four columns."""
    pairs = [
        (side // 2 - 1, side // 2) if axis in axes else (side // 2 - 3,)
        for axis in range(dimension)
    ]
    lights = [{"kind": "cell", "cell": cell, "flux": 1.0} for cell in itertools.product(*pairs)]
    places = itertools.product((side / 4, side * 3 / 4), repeat=2)
    columns = [_column(*place, side, dimension) for place in places]
    occluders = columns if walled else []
    grid = {"shape": [side] * dimension}
    return Scene.from_dict({"grid": grid, "light": lights, "occluder": occluders})


def _column(x: float, y: float, side: int, dimension: int) -> dict[str, object]:
    if dimension == 2:
        return {"kind": "circle", "center": [x, y], "radius": 2.0, "segments": 8, "albedo": 0.6}
    lower, upper = [x - 1.5, y - 1.5, 0.25 * side], [x + 1.5, y + 1.5, 0.75 * side]
    return {"kind": "box", "min": lower, "max": upper, "albedo": 0.6}


def _step_seconds(scene: Scene, name: str) -> tuple[int, float, float]:
    """Axes that were folded, and seconds of a step of the part and of the whole, once all is lit.

    In turn, best of many.
    """
    part, whole = runs = [
        Simulation(scene, propagators.create(name), precision="float32") for _ in range(2)
    ]
    best = [float("inf")] * 2
    for _ in range(12):
        for number, run in enumerate(runs):
            run.inject()
            if run is whole:
                run.octree.levels[0].light.unfold()
            run.run(scene.grid.shape[0])
            begin = time.perf_counter()
            run.run(_STEPS)
            best[number] = min(best[number], (time.perf_counter() - begin) / _STEPS)
    assert not whole.octree.levels[0].light.fold.axes
    return len(part.octree.levels[0].light.fold.axes), *best


@pytest.mark.parametrize("walled", [False, True], ids=["open", "bounces"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_images_are_not_stepped(
    dimension: int, walled: bool, report: Callable[[str], None]
) -> None:
    rows: list[list[object]] = []
    for name, side in itertools.product(_NAMES[dimension], _SIDES[dimension]):
        for axes in ((0,), tuple(range(dimension))):
            scene = _scene(side, dimension, axes, walled)
            folded, part, whole = _step_seconds(scene, name)
            label = f"{name}, {side}^{dimension}"
            rows.append([label, len(axes), folded, whole * 1e6, part * 1e6, whole / part])
    head = ["float32, 2 bands", "axes", "folded", "whole [µs]", "part [µs]", "ratio"]
    report("\n" + table(head, rows))
    # What does not pay is left alone: the same run twice, which tells noise and nothing else.
    ratios = [float(str(row[-1])) for row in rows if row[2]]
    assert min(ratios) > 0.9
    assert max(ratios) > (2 if dimension == 2 or walled else 3)
