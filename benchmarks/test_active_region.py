"""What light that has not arrived costs: k steps from one cell, on a large grid and a small one."""

from __future__ import annotations

import time

import pytest

import propagators
from flatland import Scene, Simulation
from studies.tables import table

_STEPS = (8, 32, 128)


def _lone(side: int, dimension: int) -> Scene:
    middle = [side // 2] * dimension
    lights = [{"kind": "cell", "cell": middle, "flux": 1.0}]
    return Scene.from_dict({"grid": {"shape": [side] * dimension}, "light": lights})


def _seconds(simulation: Simulation, steps: int) -> float:
    """Best of several runs, injection apart."""
    best = float("inf")
    for _ in range(12):
        simulation.inject()
        # The small grid's light is its own mirror image, the large one's is not: other savings.
        simulation.octree.levels[0].light.unfold()
        begin = time.perf_counter()
        simulation.run(steps)
        best = min(best, time.perf_counter() - begin)
    return best


@pytest.mark.parametrize(
    ("name", "dimension", "side"), [("lpv", 2, 1024), ("dom8", 2, 1024), ("lpv", 3, 128)]
)
def test_cells_that_light_has_not_reached_cost_nothing(
    name: str, dimension: int, side: int, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = []
    for steps in _STEPS if dimension == 2 else _STEPS[:2]:
        large, small = (
            Simulation(_lone(cells, dimension), propagators.create(name), bands=2)
            for cells in (side, 2 * steps + 1)
        )
        pair = [_seconds(large, steps), _seconds(small, steps)]
        rows.append([steps, 2 * steps + 1, pair[0] * 1e6, pair[1] * 1e6, pair[0] / pair[1]])
    with capsys.disabled():
        head = ["steps", "small grid", f"{side}^{dimension} [µs]", "small [µs]", "ratio"]
        print(f"\n{name}, one lit cell\n{table(head, rows)}")
    # In space the rows of a box lie far apart in a large grid.
    assert max(row[-1] for row in rows) < (1.5 if dimension == 2 else 2.0)
