"""How the work for a converged field grows with the grid, to 1e-8, for any scheme and walls.

Applications are those of the operator on the whole grid; where a method iterates at the border and
on walls alone, each of its iterations counts as one. On small grids `solve` factorises all of these
cells and takes 8 to 14; here it iterates on all grids, so that growth is that of one method.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import pytest

import propagators
from flatland import Scene, Simulation, load_scene
from flatland.errors import ConvergenceError
from flatland.solvers import patches

_SIDES = {2: (64, 128, 256, 512), 3: (16, 32, 64)}
#: Scheme, bands, dimension, walls.
_ROWS = [
    *(("lpv", bands, 2, walls) for bands in (2, 5) for walls in ("open", "exact", "fuzzy")),
    *(("lpv-2009", 2, 2, walls) for walls in ("open", "exact")),
    *(("dom4", 2, 2, walls) for walls in ("open", "exact")),
    *(("dom8", 2, 2, walls) for walls in ("open", "exact", "fuzzy")),
    *(("dom8", bands, 2, walls) for bands in (3, 5) for walls in ("open", "exact")),
    *((name, 2, 3, walls) for name in ("lpv", "dom6", "dom26") for walls in ("open", "exact")),
]
_LARGEST_GROWTH = 2.0


def _scene(side: int, dimension: int, walls: bool) -> Scene:
    data: dict[str, object] = {"grid": {"shape": [side] * dimension}}
    if dimension == 2:
        data["light"] = [
            {"kind": "area", "start": [0.3 * side, 1.0], "end": [0.6 * side, 1.0], "flux": 5.0}
        ]
        occluders = [
            _polygon(side, [(0.2, 0.4), (0.45, 0.45), (0.3, 0.7)]),
            {
                "kind": "segment", "albedo": 0.8,
                "start": [0.6 * side, 0.3 * side], "end": [0.8 * side, 0.72 * side],
            },
            {
                "kind": "circle", "albedo": 0.0,
                "center": [0.62 * side, 0.83 * side], "radius": 0.08 * side,
            },
        ]  # fmt: skip
    else:
        data["light"] = [{"kind": "cell", "cell": [side // 3] * 3, "flux": 5.0}]
        corners = [(0.1, 0.7, 0.1), (0.6, 0.7, 0.1), (0.6, 0.75, 0.8), (0.1, 0.75, 0.8)]
        occluders = [
            {
                "kind": "box", "albedo": 0.5,
                "min": [0.5 * side, 0.2 * side, 0.2 * side],
                "max": [0.7 * side, 0.4 * side, 0.8 * side],
            },
            {**_polygon(side, corners), "kind": "quad"},
        ]  # fmt: skip
    if walls:
        data["occluder"] = occluders
    return Scene.from_dict(data)


def _moved(run: Simulation, scene: Scene) -> Iterator[None]:
    """With the light at two other places, so that the last answer is of no use."""
    for share in (0.2, 0.6):
        place = [int(share * cells) for cells in scene.grid.shape]
        light = {"kind": "cell", "cell": place, "flux": 5.0}
        run.relight(Scene.from_dict({**scene.to_dict(), "light": [light]}))
        yield


def _polygon(side: int, corners: list[tuple[float, ...]]) -> dict[str, object]:
    vertices = [[side * place for place in corner] for corner in corners]
    return {"kind": "polygon", "albedo": 0.5, "vertices": vertices}


@pytest.mark.parametrize(("name", "bands", "dimension", "walls"), _ROWS)
def test_growth(name, bands, dimension, walls, report, monkeypatch):
    monkeypatch.setattr(patches, "_ALL", 0)
    counts, per_unknown, cells = [], [], []
    for side in _SIDES[dimension]:
        blocking = "none" if walls == "open" else walls
        scene = _scene(side, dimension, walls != "open")
        run = Simulation(scene, propagators.create(name), bands=bands, blocking=blocking)
        begin = time.perf_counter()
        first = run.solve(1e-8)
        whole = time.perf_counter() - begin
        others = [run.solve(1e-8) for _ in _moved(run, scene)]
        again = min(others, key=lambda result: result.seconds)
        counts.append(first.applications)
        per_unknown.append(again.seconds / run.accumulated.values.size)
        cells.append(
            f"{first.applications:4d} {first.method:9} {again.seconds:6.3f}/{whole:6.2f} s"
        )
    growth = counts[-1] / counts[0]
    row = f"{name} {bands} bands {dimension}D {walls}"
    report(
        f"{row:24} | {' | '.join(cells)} | {growth:.2f} applications, "
        f"{per_unknown[-1] / per_unknown[0]:.1f} time per unknown"
    )
    assert growth <= _LARGEST_GROWTH
    if (name, bands, dimension, walls) == ("lpv", 2, 2, "open"):
        assert growth <= 1.5
        assert counts[-1] <= 80
        assert per_unknown[-1] <= 4 * per_unknown[0]


@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8"])
def test_growth_in_clutter(name, report):
    """As many walls for each cell on every grid; against BiCGSTAB alone on the largest."""
    counts, cells = [], []
    for side in _SIDES[2]:
        scene = load_scene(f"clutter:size={side},occluders={25 * (side // 64) ** 2}")
        run = Simulation(scene, propagators.create(name), bands=2, blocking="exact")
        begin = time.perf_counter()
        result = run.solve(1e-8, "aggregation")
        whole = time.perf_counter() - begin
        counts.append(result.applications)
        cells.append(f"{result.applications:4d} {result.seconds:6.3f}/{whole:6.2f} s")
    alone = Simulation(scene, propagators.create(name), bands=2, blocking="exact")
    try:
        seconds = alone.solve(1e-8, "krylov").seconds
    except ConvergenceError:
        seconds = math.inf
    report(
        f"{name} 2 bands 2D clutter | {' | '.join(cells)} | {counts[-1] / counts[0]:.2f} "
        f"applications; BiCGSTAB alone {seconds:.2f} s"
    )
    assert counts[-1] <= 1.5 * counts[0]
    assert seconds > 1.5 * result.seconds
