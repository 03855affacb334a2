"""`flatland bench`: how near steps come to the speed of memory and arithmetic here."""

from __future__ import annotations

import json
from typing import Any

import click

from studies.commands.options import whole_numbers

_HEADER = (
    "scheme",
    "cells",
    "bands",
    "µs a step",
    "ns a cell",
    "x main memory",
    "x same arrays",
    "x arithmetic",
    "x limit",
)


@click.command("bench")
@click.option("--propagator", "names", multiple=True, metavar="NAME", help="A scheme; all of them.")
@click.option("--bands", default="2,4", show_default=True, help="Angular bands, a list.")
@click.option("--sizes", default="128,512", show_default=True, help="Cells a side in 2D, a list.")
@click.option("--sizes-3d", default="64", show_default=True, help="Cells a side in 3D, a list.")
@click.option("--precision", default="float32", show_default=True, help="float64 or float32.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def command(
    names: tuple[str, ...], bands: str, sizes: str, sizes_3d: str, precision: str, as_json: bool
) -> None:
    """Time a step of each scheme, as a ratio to what its memory traffic and arithmetic take.

    All limits are measured in the same run, so that ratios can be compared between machines and
    busy hours; times cannot. FLATLAND_THREADS sets the number of threads.
    """
    from flatland.errors import bad_input
    from flatland.simulation import PRECISIONS
    from studies.bench.steps import bench_rows, stencil_names
    from studies.machine import describe_machine
    from studies.progress import steps_bar

    if precision not in PRECISIONS:
        raise bad_input("--precision", precision, "is unknown", PRECISIONS)
    for name in names:
        if name not in stencil_names():
            raise bad_input("--propagator", name, "is no scheme that steps", stencil_names())
    counts = whole_numbers(bands, "--bands")
    sides = {2: whole_numbers(sizes, "--sizes"), 3: whole_numbers(sizes_3d, "--sizes-3d")}
    rows: list[dict[str, Any]] = []
    with steps_bar(len(names or stencil_names())) as advance:
        for row in bench_rows(names, sides, counts, precision):
            if advance is not None and rows and rows[-1]["scheme"] != row["scheme"]:
                advance(1)
            rows.append(row)
    machine = describe_machine()
    if as_json:
        click.echo(json.dumps({"machine": machine, "rows": rows}, indent=1))
    else:
        click.echo(_report(machine, rows, precision))


def _report(machine: dict[str, Any], rows: list[dict[str, Any]], precision: str) -> str:
    from studies.tables import table

    shown = [
        [
            row["scheme"],
            f"{row['side']}{'²' if row['dimension'] == 2 else '³'}",
            row["bands"],
            1e6 * row["seconds"],
            row["nanoseconds_per_cell"],
            row["over_main_memory"],
            row["over_same_arrays"],
            row["over_arithmetic"],
            row["over_limit"],
        ]
        for row in rows
    ]
    where = f"{machine['processor']}, {machine['threads']} threads, {precision}"
    notes = (
        "x main memory: the step's time over that of its traffic at the speed of main memory",
        "x same arrays: over that of its traffic on arrays of the same size, cached as they are",
        "x arithmetic: over that of its additions and multiply-adds, from registers",
        "x limit: over the largest of the three",
    )
    return "\n".join([where, "", table(_HEADER, shown), "", *notes])
