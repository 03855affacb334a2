"""`flatland figure`: the figures of the papers, and ours."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import click


@click.command("figure")
@click.argument("names", nargs=-1)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("out"),
    show_default=True,
    help="Folder for PDF, PNG and data.",
)
@click.option(
    "--data", "from_data", is_flag=True, help="Draw from the data that is there, compute nothing."
)
@click.option("--jobs", type=int, help="Processes for studies. [default: all cores]")
def command(names: tuple[str, ...], output: Path, from_data: bool, jobs: int | None) -> None:
    """Make the figures NAMES, or `all`; without a name, list them.

    Each is written as PDF and PNG, with the data behind it; the same data gives the same bytes.
    Studies that figures draw on run in OUTPUT/studies, and go on where they were interrupted.
    """
    from studies.figures import FIGURES
    from studies.tables import table

    if not names:
        click.echo(table(["figure", "shows"], [[key, text] for key, (_, text) in FIGURES.items()]))
        return
    for name in _chosen(names):
        for path in _make(name, output, from_data, jobs):
            click.echo(f"wrote {path}")


def _chosen(names: tuple[str, ...]) -> list[str]:
    from flatland.errors import bad_input
    from studies.figures import FIGURES

    for name in names:
        if name not in FIGURES and name != "all":
            raise bad_input("figure", name, "is unknown", [*FIGURES, "all"])
    return list(FIGURES) if "all" in names else list(dict.fromkeys(names))


def _make(name: str, folder: Path, from_data: bool, jobs: int | None) -> list[Path]:
    from flatland.results import load_dataset
    from studies.figures import FIGURES
    from studies.style import figure_style, save_figure

    module = importlib.import_module(FIGURES[name][0])
    stored = {part: folder / f"{name}-{part}.nc" for part in module.PARTS}
    written = [] if from_data else _store(module, folder, stored, jobs)
    data = {part: load_dataset(path) for part, path in stored.items()}
    with figure_style():
        for part, figure in module.draw(data).items():
            stem = f"{name}-{part}" if part else name
            for ending in (".pdf", ".png"):
                written.append(save_figure(figure, folder / f"{stem}{ending}"))
    return written


def _store(module: Any, folder: Path, stored: dict[str, Path], jobs: int | None) -> list[Path]:
    """Compute and keep the data of a figure; rows also as a spreadsheet."""
    from flatland.results import save_dataset
    from studies.figures.workshop import StudyFolder
    from studies.sweeps.table import write_csv

    data = module.compute(StudyFolder(folder, jobs))
    written = []
    for part, path in stored.items():
        written.append(save_dataset(data[part], path))
        if "row" in data[part].dims:
            written.append(write_csv(data[part], path.with_suffix(".csv")))
    return written
