"""One look for all figures: sizes, colours, and files with the same bytes from the same data."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from flatland.errors import bad_input
from flatland.results import write_atomically

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


@dataclass(frozen=True)
class Line:
    """How a method is drawn: a colour of Okabe and Ito's set; in grey, the rest tells.

    dashes, width: of the outline of a lobe. curve, marker: of a curve over some axis, which has
    room for longer dashes and for a marker at each point.
    """

    colour: str
    dashes: Any = "-"
    width: float = 0.6
    curve: Any = "-"
    marker: str = "o"


#: The cascaded LPV paper's colours for figure 5: DOM8 green, DOM4 blue, LPV red, analytic grey.
LINES = {
    "analytic": Line("#b0b0b0", curve=(0, (1, 1)), marker="*"),
    "lpv": Line("#d55e00", width=0.9, curve="-", marker="o"),
    "dom4": Line("#0072b2", (0, (3, 1)), curve=(0, (4, 1.5)), marker="s"),
    "dom8": Line("#009e73", width=0.5, curve=(0, (4, 1.2, 1, 1.2)), marker="^"),
    "lpv-2009": Line("#cc79a7", (0, (4, 1, 1, 1)), curve=(0, (1.2, 1.2)), marker="v"),
    "dom6": Line("#56b4e9", (0, (3, 1)), curve=(0, (4, 1.5)), marker="D"),
    "dom26": Line("#000000", width=0.5, curve=(0, (4, 1.2, 1, 1.2)), marker="P"),
}
_SPARE = (
    Line("#e69f00", "-.", curve="-.", marker="X"),
    Line("#999999", "-.", curve=(0, (6, 1)), marker="<"),
    Line("#f0e442", "-.", curve=(0, (2, 1)), marker=">"),
)


def line_of(name: str) -> Line:
    """The style of a method; methods without one of their own get a spare one by name."""
    return LINES.get(name) or _SPARE[sum(name.encode()) % len(_SPARE)]


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
