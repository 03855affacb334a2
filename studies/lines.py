"""How methods are drawn everywhere: colours, dashes and widths, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


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
#: Schemes in 3D look like their twins in 2D.
LINES = {
    "analytic": Line("#b0b0b0", curve=(0, (1, 1)), marker="*"),
    "lpv": Line("#d55e00", width=0.9, curve="-", marker="o"),
    "dom4": Line("#0072b2", (0, (3, 1)), curve=(0, (4, 1.5)), marker="s"),
    "dom8": Line("#009e73", width=0.5, curve=(0, (4, 1.2, 1, 1.2)), marker="^"),
    "lpv-2009": Line("#cc79a7", (0, (4, 1, 1, 1)), curve=(0, (1.2, 1.2)), marker="v"),
    "dom6": Line("#0072b2", (0, (3, 1)), curve=(0, (4, 1.5)), marker="D"),
    "dom26": Line("#009e73", width=0.5, curve=(0, (4, 1.2, 1, 1.2)), marker="P"),
}
_SPARE = (
    Line("#e69f00", "-.", curve="-.", marker="X"),
    Line("#999999", "-.", curve=(0, (6, 1)), marker="<"),
    Line("#f0e442", "-.", curve=(0, (2, 1)), marker=">"),
)


def line_of(name: str) -> Line:
    """The style of a method; methods without one of their own get a spare one by name."""
    return LINES.get(name) or _SPARE[sum(name.encode()) % len(_SPARE)]
