"""False scattering: a sweep mixes light over every face it crosses, whatever its ordinates.

The flux of `shelf` by 256 ordinates swept with step, diamond and step characteristics, and the
exact answer: light is smeared over the edge of the shadow, into cells that are dark. `plateaus`:
the error in `fig5-one-light` by number of ordinates, where sweeps stall and beams, which mix
nothing, do not; and by cells per cell of the scene, at 256 ordinates a sweep. Finer cells help with
a power of at most one.
"""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.answers import Answers, Asked
from studies.figures.curves import legend_above, panels, plain_log, whole_ticks
from studies.figures.snapshots import draw_maps, snapshot_data
from studies.figures.workshop import Workshop
from studies.metrics import leak
from studies.style import Style

PARTS = ("snapshots", "rows")
SCENE, CURVES, BANDS = "shelf", "fig5-one-light", 2
ORDINATES = 256
COUNTS = (16, 32, 64, 128, 256, 512)
RESOLUTIONS = (1, 2, 4)
_RULES = ("step", "diamond", "step-characteristics")
_STYLES: dict[str, Style] = {
    "step": {"color": "#d55e00", "marker": "s", "linestyle": (0, (4, 1.5))},
    "diamond": {"color": "#009e73", "marker": "D", "linestyle": (0, (4, 1.2, 1, 1.2))},
    "step-characteristics": {"color": "#e69f00", "marker": "^", "linestyle": (0, (1.2, 1.2))},
    "beam": {"color": "#0072b2", "marker": "o", "linestyle": "-"},
}


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    answers = Answers()
    sweeps = [_asked(rule, ORDINATES, SCENE) for rule in _RULES]
    exact = Asked(SCENE, "analytic", {}, BANDS)
    scene, truth = answers.scene(exact), answers.exact(exact)
    fields = {rule: each.field(scene) for rule, each in zip(_RULES, sweeps)}
    leaks = [leak(field, truth) for field in fields.values()] + [0.0]
    fields["exact answer"] = truth
    commands = [each.command for each in (*sweeps, exact)]
    meaning = "share of all flux in cells that are dark in truth"
    return {
        "snapshots": snapshot_data(scene, fields, commands, leak=(leaks, meaning)),
        "rows": _rows(answers),
    }


def _asked(rule: str, ordinates: int, scene: str, resolution: int = 1) -> Asked:
    if rule == "beam":
        return Asked(scene, "beam", {"ordinates": ordinates}, BANDS, resolution)
    return Asked(scene, "sn", {"rule": rule, "ordinates": ordinates}, BANDS, resolution)


def _rows(answers: Answers) -> xr.Dataset:
    """By number of ordinates at resolution 1, then by resolution at ORDINATES."""
    cases = [(rule, count, 1) for rule in _STYLES for count in COUNTS]
    cases += [(rule, ORDINATES, k) for rule in _RULES for k in RESOLUTIONS if k > 1]
    asked = [_asked(rule, count, CURVES, k) for rule, count, k in cases]
    return answers.rows(
        asked, rule=[case[0] for case in cases], ordinates=[case[1] for case in cases]
    )


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    return {"": _maps(data["snapshots"]), "plateaus": _plateaus(data["rows"])}


def _maps(snapshots: xr.Dataset) -> Figure:
    def title(name: str) -> str:
        share = float(snapshots["leak"].sel(snapshot=name))
        return f"leak {share:.2%}" if share else ""

    return draw_maps(snapshots, 2, 2, 1.2, title)[0]


def _plateaus(rows: xr.Dataset) -> Figure:
    figure, (left, right) = panels(2, sharey=True, legend=0.42)
    for rule, style in _STYLES.items():
        own = rows.isel(row=rows["rule"].values == rule)
        coarse = own.isel(row=own["resolution"].values == 1).sortby("ordinates")
        left.plot(coarse["ordinates"], coarse["error"], markersize=2.6, **style)
        if rule == "beam":
            continue
        many = own.isel(row=own["ordinates"].values == ORDINATES).sortby("resolution")
        right.plot(many["resolution"], many["error"], markersize=2.6, **style)
    left.set_yscale("log")
    plain_log(left, [16, 64, 256], "x")
    left.set(xlabel="ordinates M", ylabel="error, relative L2", title="17² cells")
    right.set_xscale("log")
    whole_ticks(right, [int(k) for k in sorted(set(rows["resolution"].values.tolist()))])
    right.set(xlabel="cells per cell, along an axis", title=f"{ORDINATES} ordinates")
    entries = [Line2D([], [], label=rule, markersize=3, **_STYLES[rule]) for rule in _STYLES]
    legend_above(figure, entries, 2)
    return figure
