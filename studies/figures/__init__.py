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
    "octree-fig7": (
        "studies.figures.octree_fig7",
        "the index volume, three levels and what is sampled from them (octree thesis, figure 7)",
    ),
    "octree-fig9": (
        "studies.figures.octree_fig9",
        "two lit walls, all levels merged (octree thesis, figure 9)",
    ),
    "octree-fig14": (
        "studies.figures.octree_fig14",
        "intensity jumps where levels meet (octree thesis, figure 14)",
    ),
    "octree-fig15": (
        "studies.figures.octree_fig15",
        "the thesis' errors after each iteration, and against the uniform grid (figure 15)",
    ),
    "octree-fig16": (
        "studies.figures.octree_fig16",
        "light that turns back behind a directed source (octree thesis, figure 16)",
    ),
    "octree-fig17": (
        "studies.figures.octree_fig17",
        "the index volume's jump beside a light, and its remedy (octree thesis, figure 17)",
    ),
    "octree-table1": (
        "studies.figures.octree_table1",
        "time of each part of a frame, octree against uniform grid (octree thesis, table 1)",
    ),
    "bands": ("studies.figures.bands", "error by number of bands, over its floor, scene by scene"),
    "levels": ("studies.figures.levels", "error by octree level and iteration"),
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
    "pareto": (
        "studies.figures.pareto",
        "run time against error of the schemes that step, with the front",
    ),
    "pareto-all": (
        "studies.figures.pareto_all",
        "run time against error of every propagator, scene by scene",
    ),
    "drift": ("studies.figures.drift", "energy made or lost by schemes and options"),
    "blocking": ("studies.figures.blocking", "leak through walls by strength of fuzzy blocking"),
    "ray-effects": (
        "studies.figures.ray_effects",
        "fans between a few ordinates, and the error by their number",
    ),
    "false-scattering": (
        "studies.figures.false_scattering",
        "light that sweeps mix over faces: into a shadow, and as a limit to their error",
    ),
    "penumbra": (
        "studies.figures.penumbra",
        "flux from light through half shadow to dark, by stencils and by accurate schemes",
    ),
    "medium-moments": (
        "studies.figures.medium_moments",
        "how far light spreads in a medium: mean square and fourth power over the exact ones",
    ),
}
