"""The textbook discrete ordinates: one sweep over the grid for each direction, as a propagator."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.threads import thread_count
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.base import Answer, DirectPropagator, Option
from propagators.options import BOUNCES, ELEMENT
from propagators.sn.sweeping import RULES, Sweeps
from propagators.transport.ordinates import Ordinates, chosen_count
from propagators.transport.problem import DirectProblem, read_problem
from propagators.transport.settling import iterated_flux, settled_flux

Array = NDArray[np.float64]

#: Ordinates without being asked: one for each cell along the longest side, at least this many.
FEWEST = 64


class GridSweeps(DirectPropagator):
    """Discrete ordinates on the grid, S_N: a sweep from cell to cell for each of M directions.

    Rules and formulas: numerics §12.

    rule="step": what leaves a cell has its mean radiance. "diamond": the mean of opposite faces is
    the cell's. "step-characteristics": radiance is constant on each face where light enters and the
    rays are followed exactly; conserves, never negative, the best plain choice. These three
    (Carlson and Lathrop 1968; Lewis and Miller 1984) conserve flux and know mean radiances of faces
    alone; cells that segments cut are crossed exactly, light being uniform on each face where it
    enters. "nodal": short characteristics to cell corners with linear interpolation (Kunasz and
    Auer 1988).

    Lights do not block unless `lights_block`: light that is mixed over a face would fall back onto
    the rear of the light that sent it. What each surface emits is scaled so that its flux is exact.
    Walls reflect diffusely, with one radiance on each element of at most `element` cells. Points
    and parallel light make their first flight in closed form.

    What it gets wrong: false scattering. Radiance is mixed over each face, so that beams widen like
    √distance (step), or with the direction (the others: none along the axes, for diamond and nodal
    none along the diagonals); more ordinates do not help, more cells slowly: 4 to 27 % are left.
    `fig5-one-light` shows it beside `beam`, which has ray effects alone. Light mixed over a face
    that a wall ends on leaks to the other side of the wall: `shelf`. Lights cast no shadow.
    "diamond" overshoots beside a shadow, and what would be negative is set to 0, so that lights do
    not superpose exactly. "nodal" loses light: it keeps 70 % of that of a light on a grid line.
    """

    name = "sn"
    summary = "discrete ordinates swept over the grid: step, diamond, characteristics"
    dimensions: ClassVar = (2,)
    options = (
        Option(
            "rule",
            str,
            "step-characteristics",
            "how a cell is crossed",
            tuple(RULES),
        ),
        Option(
            "ordinates",
            int,
            0,
            "directions, a multiple of 4; 0: one for each cell along the longest side",
            minimum=0,
            maximum=2**17,
        ),
        Option("lights_block", bool, False, "lights stop light like black walls"),
        ELEMENT,
        BOUNCES,
    )

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field, its books, and in the details `ordinates`."""
        self.require_scene(scene)
        problem = read_problem(scene, bands, self.values["element"], self.values["bounces"])
        count = chosen_count(self.values["ordinates"], scene.grid.shape, bands, 1, FEWEST)
        needed = (thread_count() + 2) * problem.colours * problem.basis.size
        require_memory(needed * scene.grid.cell_count * 8, "bands", bands)
        sweeps = Sweeps(problem, self.values["rule"], Ordinates(count), self.values["lights_block"])
        sent = np.zeros((problem.surfaces.count, 2, problem.colours))
        if problem.surfaces.arrangement.reflects:
            sent = self._reflected(problem, sweeps)
        found = sweeps.run(sent, problem.basis)
        emitted, reflected = problem.light_flux, sent.sum(axis=(0, 1))
        created = None if self.values["rule"] == "nodal" else 0 * emitted
        books = problem.books(emitted, reflected, found.left, found.arrived, created)
        values = found.cells.reshape(*problem.shape, problem.colours, -1).transpose(2, 3, 0, 1)
        return problem.answer(np.ascontiguousarray(values), books, {"ordinates": count})

    def _reflected(self, problem: DirectProblem, sweeps: Sweeps) -> Array:
        """Flux (E, 2, C) that walls send back."""
        albedo, start = problem.surfaces.albedo, problem.sizeless_flux
        if self.values["rule"] == "diamond":
            # Not linear, as negative radiances are cut off.
            return iterated_flux(lambda flux: sweeps.run(flux, None).arrived + start, albedo)
        direct = sweeps.run(np.zeros_like(start), None).arrived + start
        return settled_flux(
            lambda flux: sweeps.run(flux, None, lights=False).arrived, albedo, direct
        )
