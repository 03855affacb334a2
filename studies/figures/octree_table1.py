"""Table 1 of the octree thesis: time of each part of a frame, octree against uniform grid.

A grid of 64² with walls, LPV with 2 bands; the octree with all levels and k = 4 iterations, the
uniform grid with k = 16, as the thesis compares them. Medians of several runs after one that is not
counted; the quartiles are in the data. Times of one machine: ratios carry over.
"""

from __future__ import annotations

import json
from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from flatland.octree import most_levels
from flatland.results import versions
from flatland.scene import Scene, load_scene, scene_to_toml
from propagators import StencilPropagator, create
from studies.figures.workshop import Workshop
from studies.kinds.timing import Timing
from studies.level_payoff import action_seconds
from studies.machine import describe_machine
from studies.style import COLUMN

PARTS = ("rows",)
SCENE, BANDS, BLOCKING = "clutter:size=64", 2, "fuzzy"
#: Iterations of the uniform grid and of the octree.
UNIFORM_STEPS, OCTREE_STEPS = 16, 4
#: Timed runs.
REPEATS = 7
_PARTS = {
    "inject_geometry": "geometry: inject",
    "downsample_geometry": "geometry: downsample",
    "inject": "light: inject",
    "downsample": "light: downsample",
    "propagate": "propagate",
    "merge": "index and merge",
}
_COMMAND = (
    'python -c "from studies.level_payoff import action_seconds; from flatland.scene import '
    "load_scene; from propagators import create; print(action_seconds(load_scene('{}'), "
    "create('lpv'), {}, {}, {}, blocking='{}'))\""
)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    levels = most_levels(scene.grid.shape)
    rows = []
    for count, steps in ((1, UNIFORM_STEPS), (levels, OCTREE_STEPS)):
        times = _times(scene, count, steps)
        command = _COMMAND.format(SCENE, BANDS, count, steps, BLOCKING)
        for part in _PARTS:
            time = times[part]
            rows.append((part, count, steps, time.median, time.low, time.high, command))
    names = ("part", "levels", "iterations", "seconds", "seconds_low", "seconds_high", "command")
    data = xr.Dataset({name: ("row", list(values)) for name, values in zip(names, zip(*rows))})
    for name, meaning in zip(names[3:6], ("median", "lower quartile", "upper quartile")):
        data[name].attrs = {"units": "s", "long_name": f"{meaning} of {REPEATS} runs"}
    data = data.assign_coords(row=[f"{part}.{count}" for part, count, *_ in rows])
    data.attrs = {
        "scene": scene_to_toml(scene),
        "machine": json.dumps(describe_machine(), sort_keys=True),
        "versions": json.dumps(versions(), sort_keys=True),
    }
    return {"rows": data}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    counts = sorted(set(rows["levels"].values.tolist()))
    keys = zip(rows["part"].values.tolist(), rows["levels"].values.tolist())
    micro = dict(zip(keys, 1e6 * rows["seconds"].values))
    lines = {name: [micro[part, count] for count in counts] for part, name in _PARTS.items()}
    frame = ("inject", "downsample", "propagate", "merge")
    lines["a frame of moving light"] = [sum(micro[part, n] for part in frame) for n in counts]
    cells = [[name, *(f"{value:,.0f}" for value in values)] for name, values in lines.items()]
    figure = Figure(figsize=(COLUMN, 0.17 * (len(cells) + 1) + 0.15), layout="constrained")
    axes = figure.subplots()
    axes.axis("off")
    drawn = axes.table(
        cells,
        colLabels=_header(rows, counts),
        cellLoc="right",
        edges="horizontal",
        colWidths=[0.44, 0.28, 0.28],
        bbox=Bbox.unit(),
    )
    for cell in drawn.get_celld().values():
        cell.set_linewidth(0.4)
    for line in range(len(cells) + 1):
        drawn[line, 0].set_text_props(ha="left")
    return {"": figure}


def _header(rows: xr.Dataset, counts: list[int]) -> list[str]:
    steps = {int(n): int(k) for n, k in zip(rows["levels"].values, rows["iterations"].values)}
    names = ["uniform" if count == 1 else f"{count} levels" for count in counts]
    return ["µs", *(f"{name}, k = {steps[count]}" for name, count in zip(names, counts))]


def _times(scene: Scene, levels: int, steps: int) -> dict[str, Timing]:
    """Every part's time."""
    scheme: Any = create("lpv")
    assert isinstance(scheme, StencilPropagator)
    runs = [
        action_seconds(scene, scheme, BANDS, levels, steps, repeats=1, blocking=BLOCKING)
        for _ in range(REPEATS + 1)
    ]
    return {part: Timing.of([run[part] for run in runs[1:]], runs[0][part]) for part in _PARTS}
