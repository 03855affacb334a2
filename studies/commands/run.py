"""`flatland run`: one method on one scene."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from studies.commands.options import check_stopping, method_options, scheme_options

if TYPE_CHECKING:
    from flatland.ledger import Ledger
    from flatland.scene import Scene
    from studies.running import Run


@click.command("run")
@click.argument("scene")
@click.option("--propagator", default="lpv", show_default=True, help="A scheme's name.")
@click.option("--option", "options", multiple=True, metavar="KEY=VALUE", help="Of the scheme.")
@click.option("--bands", default=2, show_default=True, help="Angular bands.")
@method_options
@click.option("--reference", is_flag=True, help="Print errors against the exact answer.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="netCDF file to write.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def command(
    scene: str,
    propagator: str,
    options: tuple[str, ...],
    bands: int,
    iterations: int | None,
    converge: float | None,
    precision: str,
    blocking: str,
    strength: float,
    no_bounces: bool,
    lights_block: bool,
    reference: bool,
    output: Path | None,
    as_json: bool,
) -> None:
    """Run one method on SCENE, a built-in name or a file, and print where its light went."""
    from flatland.results import result_dataset, save_dataset
    from flatland.scene import load_scene
    from propagators import create
    from studies.progress import steps_bar
    from studies.running import Method, run_method

    check_stopping(iterations, converge)
    loaded = load_scene(scene)
    scheme = create(propagator, **scheme_options(options))
    walls = (blocking, strength, not no_bounces, lights_block)
    method = Method(scheme, bands, iterations, converge, precision, *walls)
    with steps_bar(method.steps_on(loaded), converge is None) as advance:
        run = run_method(loaded, method, advance)
    errors = _errors(loaded, run) if reference else {}
    if output is not None:
        fields = {"accumulated": run.accumulated}
        save_dataset(result_dataset(loaded, fields, method.as_dict()), output)
    if as_json:
        click.echo(json.dumps(_record(scene, run, errors), indent=1))
    else:
        click.echo(_report(scene, loaded, run, errors))
        if output is not None:
            click.echo(f"wrote {output}")


def _errors(scene: Scene, run: Run) -> dict[str, float]:
    from studies.comparison import measure
    from studies.reference import Reference

    return measure(run.accumulated, Reference(scene))


def _record(scene: str, run: Run, errors: dict[str, float]) -> dict[str, Any]:
    books = {} if run.ledger is None else run.ledger.as_dict()
    return {
        "scene": scene,
        "method": run.method.as_dict(),
        "stopped": run.stopped,
        "seconds": run.seconds,
        **run.details,
        "ledger": {name: value.tolist() for name, value in books.items()},
        "errors": errors,
    }


def _report(name: str, scene: Scene, run: Run, errors: dict[str, float]) -> str:
    size = " x ".join(map(str, scene.grid.shape))
    method = run.method
    lines = [
        f"{name}: {size} cells, {method.propagator!r}, {method.bands} bands, {method.precision}",
        f"{run.stopped}, {run.seconds:.3g} s",
    ]
    if run.ledger is not None:
        lines += ["", _books(run.ledger)]
    if errors:
        from studies.comparison import MEANINGS
        from studies.tables import table

        rows = [[key, value, MEANINGS[key]] for key, value in errors.items()]
        lines += ["", table(["error", "value", "against the exact answer"], rows)]
    return "\n".join(lines)


def _books(ledger: Ledger) -> str:
    """emitted + created = left + absorbed + inside, a row per colour if there are several."""
    import numpy as np

    from studies.tables import table

    entries = ledger.as_dict()
    names = list(entries)
    columns = [np.atleast_1d(entries[name]) for name in names]
    rows = [[float(column[i]) for column in columns] for i in range(len(columns[0]))]
    header = [f"{name} [W]" for name in names]
    return table(header, rows)
