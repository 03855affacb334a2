"""`flatland compare`: several methods beside the exact answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from studies.commands.options import (
    check_stopping,
    level_options,
    level_values,
    method_options,
    plain_numbers,
    whole_numbers,
)

if TYPE_CHECKING:
    from flatland.scene import Scene
    from studies.comparison import Comparison
    from studies.figures.slices import Slice
    from studies.running import Method

#: Relative residual of the converged fields that are compared by default.
_CONVERGED = 1e-8
#: Compared by default, by dimension: 8 bands are 15 coefficients in 2D, but 64 in 3D.
_SCHEMES = {2: ("lpv", "dom4", "dom8"), 3: ("lpv", "dom6", "dom26")}
_BANDS = {2: "2,4,8", 3: "2,4"}
_COLUMNS = (
    "coefficients",
    "scaled",
    "best_scale",
    "scalar_flux",
    "net_flux",
    "angular",
    "floor",
    "leak",
)


@click.command("compare")
@click.argument("scene")
@click.option(
    "--propagator",
    "names",
    multiple=True,
    metavar="NAME",
    help="A scheme; may be repeated, and take options: lpv:flux=central. [default: lpv dom4 dom8; "
    "in 3D lpv dom6 dom26]",
)
@click.option("--bands", help="Angular bands, a list. [default: 2,4,8; in 3D 2,4]")
@method_options
@level_options
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="Picture to write (PNG, PDF or SVG)."
)
@click.option("--slice", "layer", metavar="AXIS=INDEX", help="Layer of a 3D picture; middle of z.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def command(
    scene: str,
    names: tuple[str, ...],
    bands: str | None,
    iterations: int | None,
    converge: float | None,
    precision: str,
    blocking: str,
    strength: float,
    no_bounces: bool,
    lights_block: bool,
    device: str,
    output: Path | None,
    layer: str | None,
    as_json: bool,
    **octree: Any,
) -> None:
    """Compare methods on SCENE with the exact answer: a table and, with -o, a picture.

    Compares converged fields unless --iterations says otherwise.
    """
    from flatland.devices import find_device
    from flatland.errors import bad_input
    from flatland.scene import load_scene
    from propagators import create
    from studies.comparison import compare
    from studies.progress import steps_bar
    from studies.running import Method

    check_stopping(iterations, converge)
    rules = level_values(octree)
    if rules["levels"] > 1 and iterations is None:
        rule = "needs --iterations: of converged levels, a merge reads none but level 0"
        raise bad_input("--levels", rules["levels"], rule)
    if iterations is None and converge is None:
        converge = _CONVERGED
    _check_ending(output)
    find_device(device)  # before the exact answer is computed
    loaded = load_scene(scene)
    shown = _read_slice(layer, loaded, output)
    names = names or _SCHEMES[loaded.grid.dimension]
    schemes = [create(name, **options) for name, options in map(_scheme, names)]
    counts = whole_numbers(_BANDS[loaded.grid.dimension] if bands is None else bands, "--bands")
    walls = (blocking, strength, not no_bounces, lights_block)
    methods = [
        Method(scheme, count, iterations, converge, precision, *walls, **rules, device=device)
        for count in counts
        for scheme in schemes
    ]
    with steps_bar(len(methods)) as done:
        comparison = compare(loaded, methods, done)
    click.echo(json.dumps(_record(scene, comparison), indent=1) if as_json else _table(comparison))
    if output is not None:
        _picture(comparison, shown, output, as_json)


def _read_slice(layer: str | None, scene: Scene, output: Path | None) -> Slice | None:
    """Which layer is drawn; one that cannot be is refused before anything is computed."""
    from flatland.errors import bad_input

    if output is None and layer is not None:
        raise bad_input("--slice", layer, "needs --output")
    if output is None:
        return None
    from studies.figures.slices import read_slice

    return read_slice(layer, scene.grid)


def _scheme(text: str) -> tuple[str, dict[str, str]]:
    """`name:key=value,key=value` as a name and its options."""
    from studies.commands.options import scheme_options

    name, _, rest = text.partition(":")
    return name, scheme_options(tuple(rest.split(",")) if rest else ())


def _check_ending(output: Path | None) -> None:
    """Before anything is computed for a picture that could not be written."""
    from flatland.errors import bad_input

    endings = (".png", ".pdf", ".svg")
    if output is not None and output.suffix.lower() not in endings:
        raise bad_input("--output", str(output), "has no known ending", endings)


def _table(comparison: Comparison) -> str:
    from studies.comparison import MEANINGS, energy_drift
    from studies.tables import table

    rows: list[list[Any]] = []
    for run, errors in zip(comparison.runs, comparison.errors):
        values = [errors[column] for column in _COLUMNS]
        label = repr(run.method.propagator)
        rows.append([label, run.method.bands, *values, energy_drift(run), run.seconds])
    header = ["scheme", "bands", *_COLUMNS, "drift", "seconds"]
    lines = [table(header, rows), ""]
    lines += [f"{column}: {MEANINGS[column]}" for column in _COLUMNS]
    lines.append("drift: flux made (+) or lost (-) by the scheme, as a share of what was emitted")
    lines += [f"not run: {_label(method)}: {reason}" for method, reason in comparison.failed]
    return "\n".join(lines)


def _label(method: Method) -> str:
    return f"{method.propagator!r}, {method.bands} bands"


def _record(scene: str, comparison: Comparison) -> dict[str, Any]:
    return {
        "scene": scene,
        "runs": [
            {
                "method": run.method.as_dict(),
                "seconds": run.seconds,
                "errors": plain_numbers(errors),
            }
            for run, errors in zip(comparison.runs, comparison.errors)
        ],
        "failed": [
            {"method": method.as_dict(), "reason": reason} for method, reason in comparison.failed
        ],
    }


def _picture(comparison: Comparison, layer: Slice | None, output: Path, quiet: bool) -> None:
    from flatland.results import save_dataset
    from studies.figures.comparison import comparison_data, draw_comparison
    from studies.style import figure_style, save_figure

    data = comparison_data(comparison, layer)
    stored = save_dataset(data, output.with_suffix(".nc"))
    with figure_style():
        drawn = save_figure(draw_comparison(data), output)
    click.echo(f"wrote {drawn} and its data {stored}", err=quiet)
