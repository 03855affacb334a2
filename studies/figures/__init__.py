"""Figures: each module computes its data, stores it, and draws from nothing else."""

from __future__ import annotations

#: name: (module, one line that says what it shows). A new figure is one module and one line.
FIGURES = {
    "clpv-fig5": (
        "studies.figures.clpv_fig5",
        "LPV, DOM4 and DOM8 against the exact intensity in every cell, for 2, 4 and 8 bands "
        "(Kaplanyan & Dachsbacher 2010, figure 5)",
    ),
}
