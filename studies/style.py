"""One look for all figures: sizes, colours, and files with the same bytes from the same data."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from flatland.errors import bad_input
from flatland.results import write_atomically
from studies.lines import LINES, line_of

__all__ = [
    "COLUMN",
    "FORMATS",
    "LINES",
    "PAGE",
    "curve_style",
    "figure_style",
    "line_of",
    "save_figure",
]

#: Arguments of Matplotlib's drawing calls.
Style = dict[str, Any]

#: Widths of a column and of a page of text [inch].
COLUMN, PAGE = 85 / 25.4, 175 / 25.4
FORMATS = (".pdf", ".png", ".svg")

_SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.labelsize": 7,
    "xtick.labelsize": 6,
    "ytick.labelsize": 6,
    "legend.fontsize": 6,
    "axes.linewidth": 0.5,
    "axes.grid": False,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.minor.width": 0.3,
    "ytick.minor.width": 0.3,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "lines.linewidth": 0.8,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "svg.hashsalt": "flatland",
    "image.cmap": "cividis",
}


def curve_style(name: str, marked: bool = True) -> Style:
    """Arguments of `Axes.plot` for a method's curve; `marked`: with a marker at each point."""
    line = line_of(name)
    marker: Style = (
        {"marker": line.marker, "markersize": 2.6, "markeredgewidth": 0.5} if marked else {}
    )
    return {"color": line.colour, "linestyle": line.curve, **marker}


@contextmanager
def figure_style() -> Iterator[None]:
    """Matplotlib with this project's settings, and nothing of the user's own."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.use("Agg")
        mpl.rcParams.update(_SETTINGS)
        yield


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a PDF, PNG or SVG, whole or not at all, without time stamps.

    Raises InputError for another ending, ResultFileError if the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() not in FORMATS:
        raise bad_input("output", str(path), "has no known ending", FORMATS)
    metadata = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}, ".png": {"Software": None}}
    buffer = io.BytesIO()
    form = target.suffix.lower()
    figure.savefig(buffer, format=form[1:], metadata=metadata[form])
    return write_atomically(target, lambda place: place.write_bytes(buffer.getvalue()))
