"""Figure 12 (below) of the cascaded LPV paper: too few iterations limit how far light gets.

The scene `shelf`, LPV with 2 bands and exact blocking, after 1, 4, 8 and 16 iterations, converged,
and the exact answer. The titles give the relative L2 error of the coefficients.
"""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flatland.scene import load_scene
from propagators import create
from studies.figures.snapshots import draw_maps, snapshot_data
from studies.figures.workshop import Workshop
from studies.metrics import relative_l2
from studies.reference import Reference
from studies.running import Method, run_method

PARTS = ("snapshots",)
SCENE, BANDS, TOLERANCE = "shelf", 2, 1e-8
STEPS = (1, 4, 8, 16)
_COMMAND = "flatland run {} --propagator {} --bands {} --reference"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene, lpv = load_scene(SCENE), create("lpv")
    exact = Reference(scene).field(BANDS)
    methods = {f"{n} step{'s' if n > 1 else ''}": Method(lpv, BANDS, n) for n in STEPS}
    commands = [_COMMAND.format(SCENE, "lpv", BANDS) + f" --iterations {n}" for n in STEPS]
    methods["converged"] = Method(lpv, BANDS, converge=TOLERANCE)
    commands.append(_COMMAND.format(SCENE, "lpv", BANDS) + f" --converge {TOLERANCE}")
    fields = {name: run_method(scene, method).accumulated for name, method in methods.items()}
    fields["exact answer"] = exact
    commands.append(_COMMAND.format(SCENE, "analytic", BANDS))
    errors = [relative_l2(field, exact) for field in fields.values()]
    meaning = "relative L2 error of the coefficients"
    return {"snapshots": snapshot_data(scene, fields, commands, error=(errors, meaning))}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    snapshots = data["snapshots"]

    def title(name: str) -> str:
        error = float(snapshots["error"].sel(snapshot=name))
        return f"error {error:.2f}" if error else ""

    return {"": draw_maps(snapshots, 2, 3, 0.88, title)[0]}
