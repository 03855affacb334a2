"""Radiance cascades, as a propagator."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.base import Answer, DirectPropagator, Option
from propagators.cascades.cascade import Cascade
from propagators.cascades.levels import Plan
from propagators.cascades.merging import BILINEAR_FIX, CHEAP_FIX, VANILLA
from propagators.options import BOUNCES, ELEMENT
from propagators.transport.problem import DirectProblem, read_problem
from propagators.transport.settling import settled_flux

Array = NDArray[np.float64]

FIXES = {"vanilla": VANILLA, "bilinear": BILINEAR_FIX, "cheap": CHEAP_FIX}
#: Relative residual of light between walls: below what a cascade gets wrong by far.
SETTLED = 1e-6


class RadianceCascades(DirectPropagator):
    """Radiance cascades (Sannikov, in 2D): near light from many probes, far light from many angles.

    Level l ≥ 1 has a square lattice of probes at spacing D_l = spacing · 2^(l-1), each of which
    looks along bins · branching^(l-1) rays at the interval of distances t_l … t_(l+1), of length
    interval · branching^l: what is far needs fine angles but coarse places (the penumbra
    condition). Level 0 are the points where light is gathered, with the bins of level 1: `nodes`
    Gauss points on every piece of every face, faces being cut where segments meet them. Levels are
    merged from the top: a ray that meets nothing sees what the level above sees in its direction,
    interpolated between 4 probes. What leaves a cell is then Σ L ∫ |n·ω| y dω over bins, in closed
    form (numerics §12).

    fix="vanilla": that, as published. "bilinear": rays run from a probe's own interval to the
    interval of each of the 4 probes and each of the bins above, so that nothing is skipped or seen
    twice. "cheap": one ray for each of the 4 probes, shared by the bins above. The fixes are
    community work.

    Walls reflect diffusely: what arrives at the elements of a wall is gathered like the light at
    faces, and sent back until it settles. Points and parallel light make their first flight in
    closed form.

    What it gets wrong: "vanilla" sees through what lies between the intervals of two levels: rings
    around lights, 1 to 4 % of the accumulated flux lost, a percent of all light in cells that are
    exactly dark (`shelf`). The fixes leave blurred penumbrae, as probes on both sides of a wall are
    mixed, and steps from the bins: 1 to 3 % with 2 bands. Light beyond a probe outside the walls is
    missing in "vanilla". Nothing is conserved: the books show what is lost as created.
    """

    name = "radiance-cascades"
    summary = "radiance cascades: probes ever sparser, rays ever finer and longer"
    dimensions: ClassVar = (2,)
    options = (
        Option(
            "fix",
            str,
            "bilinear",
            "what joins the intervals of two levels",
            tuple(FIXES),
        ),
        Option("branching", int, 4, "bins, and interval lengths, from level to level", (2, 4)),
        Option("bins", int, 64, "directions of level 1, a multiple of 4", minimum=4, maximum=4096),
        Option(
            "interval", float, 2.0, "length of the first interval, in cells", minimum=0.1,
            maximum=1e6,
        ),
        Option(
            "spacing", float, 1.0, "distance of the probes of level 1, in cells", minimum=0.1,
            maximum=64.0,
        ),
        Option("nodes", int, 2, "Gauss points on each piece of a face", minimum=1, maximum=16),
        ELEMENT,
        BOUNCES,
    )  # fmt: skip

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field, its books, and in the details `levels`."""
        self.require_scene(scene)
        problem = read_problem(scene, bands, self.values["element"], self.values["bounces"])
        cascade = self._cascade(problem)
        radiance, sent = problem.surfaces.radiance, np.zeros_like(problem.sizeless_flux)
        if problem.surfaces.arrangement.reflects:
            direct = cascade.arrived(radiance) + problem.sizeless_flux
            halves = 2 * problem.surfaces.lengths[:, None, None]
            sent = settled_flux(
                lambda flux: cascade.arrived(flux / halves),
                problem.surfaces.albedo,
                direct,
                SETTLED,
            )
            radiance = radiance + sent / halves
        values, arrived, left = cascade.gather(radiance, problem.basis)
        reflected = sent.sum(axis=(0, 1))
        books = problem.books(problem.light_flux, reflected, left, arrived)
        return problem.answer(values, books, {"levels": len(cascade.levels)})

    def _cascade(self, problem: DirectProblem) -> Cascade:
        bins = self.values["bins"]
        if bins % 4:
            raise bad_input("bins", bins, "must be a multiple of 4")
        if bins < 4 * problem.basis.bands:
            rule = f"must be at least {4 * problem.basis.bands}, 4 for each band"
            raise bad_input("bins", bins, rule)
        plan = Plan(bins, self.values["branching"], self.values["spacing"], self.values["interval"])
        cascade = Cascade(problem, plan, FIXES[self.values["fix"]], self.values["nodes"])
        needed = max(
            level.count_x * level.count_y * len(level.directions) for level in cascade.levels
        )
        require_memory(2 * needed * problem.colours * 8, "spacing", self.values["spacing"])
        return cascade
