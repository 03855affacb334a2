"""How far does the light of a cell get? Mean displacement by steps, for LPV and DOM8.

A figure of one's own, as a module of studies/figures would be: PARTS, compute and draw.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flatland import Scene, Simulation
from propagators import create
from studies.figures.workshop import Workshop
from studies.style import COLUMN, curve_style

PARTS = ("rows",)
SIDE, STEPS = 101, 48


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    """One row per scheme and step; figures of studies take `workshop.study(name)` instead."""
    light = {"kind": "cell", "cell": [SIDE // 2] * 2, "direction": [1, 0], "flux": 1.0}
    scene = Scene.from_dict({"grid": {"shape": [SIDE, SIDE]}, "light": [light]})
    across = np.arange(SIDE) - SIDE // 2
    rows = []
    for name in ("lpv", "dom8"):
        simulation = Simulation(scene, create(name), bands=4)
        simulation.inject()
        for step in range(1, STEPS + 1):
            simulation.step()
            flux = simulation.target.scalar_flux().sum(axis=1)
            rows.append((name, step, float(across @ flux / flux.sum())))
    schemes, steps, means = zip(*rows)
    columns = {"scheme": list(schemes), "steps": list(steps), "mean": list(means)}
    data = xr.Dataset({key: ("row", values) for key, values in columns.items()})
    return {"rows": data.assign_attrs(command="python displacement.py")}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    """One figure, drawn from the stored rows alone."""
    figure = Figure(figsize=(COLUMN, 0.7 * COLUMN), layout="constrained")
    axes = figure.subplots()
    for name in dict.fromkeys(data["rows"]["scheme"].values.tolist()):
        own = data["rows"].isel(row=data["rows"]["scheme"].values == name)
        axes.plot(own["steps"], own["mean"], label=name, **curve_style(name, marked=False))
    axes.set(xlabel="steps", ylabel="mean displacement [cells]")
    axes.legend()
    return {"": figure}
