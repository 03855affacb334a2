"""What figures about one propagation step share: the faces of a neighbour, and drawings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon, Rectangle, Wedge
from numpy.typing import ArrayLike, NDArray

from flatland.harmonics import CircularHarmonics
from flatland.injectors.base import unit_vector
from propagators.faces import faces_of
from propagators.regions import Arcs
from studies.style import COLUMN, line_of

Array = NDArray[np.float64]

_COMMAND = (
    'python -c "import numpy as np; from propagators.faces import faces_of; '
    'print(np.degrees(faces_of(np.array([1, 0])).regions.angles))"'
)
_FACES = ("front", "left", "right")
LIGHT, STORED = "#e6b800", "#b0b0b0"


def faces_data() -> xr.Dataset:
    """The faces of the neighbour in +x that light is sent to, one row each; lengths in cells.

    Angles as seen from the middle of the source cell: where a face begins and ends, what it
    subtends, and the two directions in which `central` flux may be sampled.
    """
    faces = faces_of(np.array([1, 0]))
    arcs = faces.regions
    assert isinstance(arcs, Arcs)
    middle = np.arctan2(faces.centres[:, 1], faces.centres[:, 0])
    columns = {
        "start": (arcs.starts, "where the face begins"),
        "stop": (arcs.stops, "where the face ends"),
        "angle": (arcs.angles, "what the face subtends"),
        "face_centre": (middle, "direction of the middle of the face"),
        "cone_centre": (arcs.starts + arcs.angles / 2, "middle of the visibility cone"),
    }
    data = xr.Dataset(coords={"row": list(_FACES)})
    for name, (values, meaning) in columns.items():
        data[name] = ("row", np.asarray(values), {"long_name": meaning, "units": "rad"})
    data["normal"] = (("row", "axis"), faces.normals, {"long_name": "out of the neighbour"})
    data["centre"] = (("row", "axis"), faces.centres, {"long_name": "middle, from the source"})
    data.attrs = {"command": _COMMAND}
    return data


def cell_row(panels: int) -> tuple[Figure, list[Axes]]:
    """Panels side by side without axes, for drawings in units of cells."""
    figure = Figure(figsize=(COLUMN, 0.36 * COLUMN), layout="constrained")
    grid = list(figure.subplots(1, panels, squeeze=False)[0])
    for axes in grid:
        axes.set_aspect("equal")
        axes.axis("off")
    return figure, grid


def draw_cell(axes: Axes, centre: ArrayLike, label: str = "") -> None:
    """A cell of side 1, its name in the lower left corner."""
    x, y = np.asarray(centre, float) - 0.5
    axes.add_patch(Rectangle((x, y), 1, 1, fill=False, edgecolor="black", linewidth=0.6))
    axes.text(x + 0.06, y + 0.06, label, fontsize=6, style="italic")


def draw_lobe(
    axes: Axes, centre: ArrayLike, normal: Sequence[float], colour: str, size: float
) -> None:
    """The clamped-cosine lobe along a normal, cut to 4 bands as cells store it; size: its tip."""
    basis = CircularHarmonics(4)
    angles = np.linspace(0, 2 * np.pi, 181)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    values = basis.evaluate(unit) @ basis.clamped_cosine(unit_vector(tuple(normal))[None])[0]
    radii = size * np.maximum(values, 0) / values.max()
    outline = np.asarray(centre) + radii[:, None] * unit
    axes.add_patch(Polygon(outline, facecolor=colour, edgecolor="black", linewidth=0.3, alpha=0.8))


def draw_wedge(axes: Axes, start: float, stop: float, radius: float, colour: str) -> None:
    """The cone of directions from the origin between two angles [rad]."""
    wedge = Wedge((0, 0), radius, np.degrees(start), np.degrees(stop), facecolor=colour, alpha=0.45)
    axes.add_patch(wedge)


def draw_arrow(axes: Axes, start: ArrayLike, stop: ArrayLike, colour: str = "black") -> None:
    style = {"arrowstyle": "-|>", "mutation_scale": 5, "linewidth": 0.7, "shrinkA": 0, "shrinkB": 0}
    axes.add_patch(FancyArrowPatch(tuple(start), tuple(stop), color=colour, **style))  # type: ignore[arg-type]


def draw_face(axes: Axes, centre: ArrayLike, normal: ArrayLike, colour: str) -> None:
    """A face of length 1, thick."""
    middle = np.asarray(centre, float)
    along = 0.5 * np.array([-np.asarray(normal, float)[1], np.asarray(normal, float)[0]])
    ends = np.array([middle - along, middle + along])
    axes.plot(*ends.T, color=colour, linewidth=1.8, solid_capstyle="butt")


def face_colours() -> list[str]:
    """Front, left, right: told apart in grey too."""
    return [line_of("lpv").colour, line_of("dom4").colour, "#7fb7d9"]
