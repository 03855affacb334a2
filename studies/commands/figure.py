"""`flatland figure`: the figures of the papers, and ours."""

from __future__ import annotations

import importlib
from pathlib import Path

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
def command(names: tuple[str, ...], output: Path, from_data: bool) -> None:
    """Make the figures NAMES, or `all`; without a name, list them.

    Each is written as PDF and PNG, with the data behind it; the same data gives the same bytes.
    """
    from studies.figures import FIGURES
    from studies.tables import table

    if not names:
        click.echo(table(["figure", "shows"], [[key, text] for key, (_, text) in FIGURES.items()]))
        return
    for name in _chosen(names):
        for path in _make(name, output, from_data):
            click.echo(f"wrote {path}")


def _chosen(names: tuple[str, ...]) -> list[str]:
    from flatland.errors import bad_input
    from studies.figures import FIGURES

    for name in names:
        if name not in FIGURES and name != "all":
            raise bad_input("figure", name, "is unknown", [*FIGURES, "all"])
    return list(FIGURES) if "all" in names else list(dict.fromkeys(names))


def _make(name: str, folder: Path, from_data: bool) -> list[Path]:
    from flatland.results import load_dataset, save_dataset
    from studies.figures import FIGURES
    from studies.style import figure_style, save_figure

    module = importlib.import_module(FIGURES[name][0])
    stored = {key: folder / f"{name}-{key}.nc" for key in module.SCENES}
    written = []
    if not from_data:
        data = module.compute()
        written += [save_dataset(data[key], path) for key, path in stored.items()]
    data = {key: load_dataset(path) for key, path in stored.items()}
    with figure_style():
        for part, figure in module.draw(data).items():
            for ending in (".pdf", ".png"):
                written.append(save_figure(figure, folder / f"{name}-{part}{ending}"))
    return written
