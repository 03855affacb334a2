"""How methods are drawn everywhere: colours, dashes and widths, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Line:
    """How a method is drawn: a colour of Okabe and Ito's set; in grey, dashes and width tell."""

    colour: str
    dashes: Any = "-"
    width: float = 0.6


#: The cascaded LPV paper's colours for figure 5: DOM8 green, DOM4 blue, LPV red, analytic grey.
#: Schemes in 3D look like their twins in 2D.
LINES = {
    "analytic": Line("#b0b0b0"),
    "lpv": Line("#d55e00", width=0.9),
    "dom4": Line("#0072b2", (0, (3, 1))),
    "dom8": Line("#009e73", width=0.5),
    "dom6": Line("#0072b2", (0, (3, 1))),
    "dom26": Line("#009e73", width=0.5),
    "lpv-2009": Line("#cc79a7", (0, (4, 1, 1, 1))),
}
_SPARE = ("#e69f00", "#56b4e9", "#000000", "#f0e442")


def line_of(name: str) -> Line:
    """The style of a method; methods without one of their own get a spare colour by name."""
    return LINES.get(name) or Line(_SPARE[sum(name.encode()) % len(_SPARE)], "-.")
