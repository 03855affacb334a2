"""Figures: each module computes its data, stores it, and draws from nothing else.

A module has PARTS, the names of its data sets; compute(workshop), which gives one data set for
each; and draw(data), which gives figures by name. What it draws is in the data: rows of a study,
each with the command that computes it again, or fields with their scene and methods.
"""

from __future__ import annotations

#: name: (module, one line that says what it shows). A new figure is one module and one line.
FIGURES = {
    "clpv-fig2": (
        "studies.figures.clpv_fig2",
        "the faces that light is sent to, and the angles they subtend (Kaplanyan & Dachsbacher "
        "2010, figure 2)",
    ),
    "clpv-fig5": (
        "studies.figures.clpv_fig5",
        "LPV, DOM4 and DOM8 against the exact intensity in every cell, for 2, 4 and 8 bands "
        "(Kaplanyan & Dachsbacher 2010, figure 5)",
    ),
    "clpv-fig11": (
        "studies.figures.clpv_fig11",
        "light that bleeds through a thin shelf, by kind of blocking (figure 11, left)",
    ),
    "clpv-fig12": (
        "studies.figures.clpv_fig12",
        "LPV after 1, 4, 8 and 16 iterations, converged, and the exact answer (figure 12, below)",
    ),
    "octree-fig2": (
        "studies.figures.octree_fig2",
        "directions evaluated, angles subtended and lobes sent (octree thesis, figure 2)",
    ),
    "octree-fig3": (
        "studies.figures.octree_fig3",
        "one lit cell, four iterations and their sum (octree thesis, figure 3)",
    ),
    "octree-fig16": (
        "studies.figures.octree_fig16",
        "light that turns back behind a directed source (octree thesis, figure 16)",
    ),
    "bands": ("studies.figures.bands", "error by number of bands, over its floor, scene by scene"),
    "iterations": (
        "studies.figures.iterations",
        "error by number of iterations, with 2 N and the converged field",
    ),
    "resolution": ("studies.figures.resolution", "error by cell size, and the fitted orders"),
    "stability": (
        "studies.figures.stability",
        "spectral radius of every scheme by bands; light over many steps of the engine",
    ),
    "dispersion": (
        "studies.figures.dispersion",
        "what a step leaves of a wave, and what a source of that wave leaves",
    ),
    "pareto": ("studies.figures.pareto", "run time against error, with the front"),
    "drift": ("studies.figures.drift", "energy made or lost by schemes and options"),
    "blocking": ("studies.figures.blocking", "leak through walls by strength of fuzzy blocking"),
}
