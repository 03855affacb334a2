"""Figure 5 of the cascaded LPV paper: three schemes and the exact intensity, cell by cell.

The paper prints neither scene sizes nor its DOM formulas; scenes and discrete ordinates are this
project's (built-in scenes fig5-one-light and fig5-l-shape). Converged fields, no clamping.
"""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flatland.scene import load_scene
from propagators import create
from studies.comparison import compare
from studies.figures.comparison import comparison_data
from studies.figures.lobes import draw_lobes, legend_entries
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

SCENES = {"fig5-one-light": "one area light", "fig5-l-shape": "two area lights"}
PARTS = tuple(SCENES)
#: Part of each scene that is drawn [m]: in a column, cells of the whole grid would be 4 mm wide.
WINDOWS = {"fig5-one-light": (3, 14, 0, 11), "fig5-l-shape": (0, 11, 0, 11)}
METHODS = ("lpv", "dom4", "dom8")
BANDS = (2, 4, 8)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    """One data set per scene."""
    methods = [
        Method(create(name), bands=bands, converge=1e-10) for bands in BANDS for name in METHODS
    ]
    return {scene: comparison_data(compare(load_scene(scene), methods)) for scene in SCENES}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    """One figure per number of bands, both scenes, a column wide."""
    return {f"{bands}-bands": _draw(data, bands) for bands in BANDS}


def _draw(data: dict[str, xr.Dataset], bands: int) -> Figure:
    figure = Figure(figsize=(COLUMN, 1.98 * COLUMN), layout="constrained")
    for axes, (scene, title) in zip(figure.subplots(len(SCENES)), SCENES.items()):
        draw_lobes(axes, data[scene], bands)
        axes.set(xlim=WINDOWS[scene][:2], ylim=WINDOWS[scene][2:])
        axes.set_title(f"{title}, {bands} bands")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
    entries = legend_entries(list(METHODS))
    figure.legend(handles=entries, loc="outside upper center", ncols=len(entries))
    return figure
