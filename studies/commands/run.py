"""`flatland run`: one method on one scene."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from studies.commands.options import (
    check_stopping,
    level_options,
    level_values,
    method_options,
    plain_numbers,
    read_view,
    scheme_options,
)

if TYPE_CHECKING:
    from flatland.field import Field
    from flatland.ledger import Ledger
    from flatland.scene import Scene
    from studies.running import LevelResult, Run
    from studies.surface import SurfaceError


#: Entries of the ledger that few scenes and methods have.
_RARE = ("medium", "dropped")


@click.command("run")
@click.argument("scene")
@click.option("--propagator", default="lpv", show_default=True, help="A scheme's name.")
@click.option("--option", "options", multiple=True, metavar="KEY=VALUE", help="Of the scheme.")
@click.option("--bands", default=2, show_default=True, help="Angular bands.")
@click.option(
    "--resolution", default=1, show_default=True, help="Cells per cell of the scene, each axis."
)
@method_options
@level_options
@click.option(
    "--view",
    default="merged",
    show_default=True,
    help="What --image shows of an octree: merged, or a level as in level:2.",
)
@click.option("--reference", is_flag=True, help="Print errors against the exact answer.")
@click.option("--surfaces", is_flag=True, help="Print errors of the light on occluders.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="netCDF file to write.")
@click.option(
    "--image", type=click.Path(path_type=Path), help="Picture to write (PNG, PDF or SVG)."
)
@click.option("--slice", "layer", metavar="AXIS=INDEX", help="Layer of a 3D picture; middle of z.")
@click.option("--drop", default=0.0, metavar="PART", help="Leave light below this part alone.")
@click.option("--explain", is_flag=True, help="Print what was skipped, and memory.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def command(
    scene: str,
    propagator: str,
    options: tuple[str, ...],
    bands: int,
    resolution: int,
    iterations: int | None,
    converge: float | None,
    precision: str,
    blocking: str,
    strength: float,
    no_bounces: bool,
    lights_block: bool,
    reference: bool,
    surfaces: bool,
    output: Path | None,
    image: Path | None,
    layer: str | None,
    as_json: bool,
    view: str,
    drop: float,
    device: str,
    explain: bool,
    **octree: Any,
) -> None:
    """Run one method on SCENE, a built-in name or a file, and print where its light went."""
    from flatland.errors import bad_input
    from flatland.scene import load_scene, refined
    from propagators import create
    from propagators.base import StencilPropagator
    from studies.progress import answer_bar, steps_bar
    from studies.running import Method, run_method

    check_stopping(iterations, converge)
    loaded = refined(load_scene(scene), resolution)
    rules = level_values(octree)
    shown = read_view(view, rules["levels"])
    if image is None and view != "merged":
        raise bad_input("--view", view, "needs --image")
    draw = _painter(loaded, image, layer, shown, rules["levels"])
    lighting = _surface_meter(loaded) if surfaces else None
    scheme = create(propagator, **scheme_options(options))
    walls = (blocking, strength, not no_bounces, lights_block)
    method = Method(
        scheme, bands, iterations, converge, precision, *walls, **rules, drop=drop, device=device
    )
    steps = converge is None and isinstance(scheme, StencilPropagator)
    with steps_bar(method.steps_on(loaded), steps) as advance:
        run = run_method(loaded, method, advance, keep_levels=True)
    with answer_bar():
        errors = _errors(loaded, run) if reference else {}
    lit = [] if lighting is None else lighting(run.accumulated)
    if output is not None:
        from flatland.results import result_dataset, save_dataset  # xarray: slow to load

        fields = {"accumulated": run.accumulated}
        levels = [level.accumulated for level in run.levels]
        save_dataset(result_dataset(loaded, fields, method.as_dict(), levels, run.index), output)
    if draw is not None:
        draw(run)
    if as_json:
        click.echo(json.dumps(_record(scene, run, errors, lit), indent=1))
    else:
        click.echo(_report(scene, loaded, run, errors, lit))
        if explain:
            click.echo(_skips(run))
        for path in (output, image):
            if path is not None:
                click.echo(f"wrote {path}")


def _errors(scene: Scene, run: Run) -> dict[str, float]:
    from studies.comparison import measure
    from studies.reference import Reference

    return measure(run.accumulated, Reference(scene, bounces=run.method.bounces))


def _surface_meter(scene: Scene) -> Callable[[Field], list[SurfaceError]]:
    """What measures the light on surfaces; refuses scenes without any before the run."""
    from studies.surface import surface_errors, surface_samples

    samples = surface_samples(scene)
    return lambda field: surface_errors(field, samples)


def _painter(
    scene: Scene, image: Path | None, layer: str | None, level: int | None, levels: int
) -> Callable[[Run], object] | None:
    """What writes the picture; refuses bad endings and slices before anything is computed.

    level: the one to show, None for the merged field.
    """
    from flatland.errors import bad_input

    if image is None:
        if layer is not None:
            raise bad_input("--slice", layer, "needs --image")
        return None
    from flatland.octree import level_grids
    from studies.figures.picture import draw_picture
    from studies.figures.slices import read_slice
    from studies.style import FORMATS, figure_style, save_figure

    if image.suffix.lower() not in FORMATS:
        raise bad_input("--image", str(image), "has no known ending", FORMATS)
    chosen = read_slice(layer, level_grids(scene.grid, levels)[level or 0])

    def paint(run: Run) -> None:
        with figure_style():
            if level is None or not run.levels:
                figure = draw_picture(run.accumulated, scene, chosen, run.index)
            else:
                figure = draw_picture(run.levels[level].accumulated, scene, chosen)
            save_figure(figure, image)

    return paint


def _record(
    scene: str, run: Run, errors: dict[str, float], lit: list[SurfaceError]
) -> dict[str, Any]:
    books = {} if run.ledger is None else run.ledger.as_dict()
    return {
        "scene": scene,
        "method": run.method.as_dict(),
        "stopped": run.stopped,
        "seconds": run.seconds,
        **run.details,
        "ledger": {name: value.tolist() for name, value in books.items()},
        "skipped": [asdict(skip) for skip in run.skips],
        "memory": None if run.memory is None else asdict(run.memory),
        **({"levels": [_level_record(level) for level in run.levels]} if run.levels else {}),
        "errors": plain_numbers(errors),
        "surfaces": [asdict(row) for row in lit],
    }


def _level_record(level: LevelResult) -> dict[str, Any]:
    books = level.ledger.as_dict()
    return {
        "shape": list(level.accumulated.grid.shape),
        "factor": level.factor,
        "cells_read": level.read,
        "ledger": {name: value.tolist() for name, value in books.items()},
    }


def _report(
    name: str, scene: Scene, run: Run, errors: dict[str, float], lit: list[SurfaceError]
) -> str:
    size = " x ".join(map(str, scene.grid.shape))
    method = run.method
    on_device = f" on {run.details['device']}" if "device" in run.details else ""
    lines = [
        f"{name}: {size} cells, {method.propagator!r}, {method.bands} bands, {method.precision}",
        f"{run.stopped}, {run.seconds:.3g} s{on_device}",
    ]
    if run.levels:
        lines += ["", _levels(run.levels)]
    elif run.ledger is not None:
        lines += ["", _books(run.ledger)]
    if errors:
        from studies.comparison import MEANINGS
        from studies.tables import table

        rows = [[key, value, MEANINGS[key]] for key, value in errors.items()]
        lines += ["", table(["error", "value", "against the exact answer"], rows)]
    if lit:
        from studies.tables import table

        header = ["light on surfaces", "cells away", "damped", "relative L2", "flux / exact"]
        shown = [
            [row.method, row.offset, "yes" if row.damping else "no", row.error, row.ratio]
            for row in lit
        ]
        lines += ["", table(header, shown)]
    return "\n".join(lines)


def _skips(run: Run) -> str:
    """What was left out, a line each."""
    from studies.tables import table

    if not run.skips:
        return "\n".join(["", "nothing was skipped", *_memory(run)])
    rows = [
        [skip.name, "" if skip.saved is None else f"{skip.saved:.1%}", skip.reason]
        for skip in run.skips
    ]
    return "\n".join(["", table(["skipped", "of its work", "because"], rows), *_memory(run)])


def _memory(run: Run) -> list[str]:
    """What the fields take and what all took, if that is known."""
    from flatland.memory import megabytes

    if run.memory is None:
        return []
    fields = f"source, target and accumulated light take {megabytes(run.memory.fields)}"
    if run.memory.peak is None:
        return ["", f"memory: {fields}"]
    return ["", f"memory: {fields}; with code and libraries, {megabytes(run.memory.peak)} at most"]


def _levels(levels: Sequence[LevelResult]) -> str:
    """One row per level, colours added up; fluxes in units of level 0's cells."""
    from studies.tables import table

    everything = [level.ledger.as_dict() for level in levels]
    names = [n for n in everything[0] if n not in _RARE or any(b[n].any() for b in everything)]
    rows = []
    for number, level in enumerate(levels):
        books = level.ledger.as_dict()
        size = " x ".join(map(str, level.accumulated.grid.shape))
        fluxes = [float(books[name].sum()) for name in names]
        rows.append([number, size, level.factor, level.read, *fluxes])
    header = ["level", "cells", "factor", "read", *(f"{name} [W]" for name in names)]
    note = "read: cells that the merge takes from a level. Flux in units of level 0's cells."
    return table(header, rows) + "\n" + note


def _books(ledger: Ledger) -> str:
    """Emitted + created = left + absorbed + inside, a row per colour if there are several.

    What takes part in few scenes, a medium or dropped light, is shown where it does.
    """
    import numpy as np

    from studies.tables import table

    entries = ledger.as_dict()
    names = [name for name in entries if name not in _RARE or np.any(entries[name])]
    columns = [np.atleast_1d(entries[name]) for name in names]
    rows = [[float(column[i]) for column in columns] for i in range(len(columns[0]))]
    header = [f"{name} [W]" for name in names]
    return table(header, rows)
