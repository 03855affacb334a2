"""Modified discrete ordinates: the first flight exact, everything after it by a stencil."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.injectors.file import FileLight
from flatland.moved_segments import cells_along
from flatland.scene import Scene
from flatland.simulation import Simulation
from propagators.analytic.balance import arriving_flux, balance
from propagators.analytic.elements import cut_walls
from propagators.base import Answer, DirectPropagator, Option, StencilPropagator
from propagators.transport.books import weighted_sum
from propagators.transport.problem import DirectProblem, read_problem
from propagators.transport.sizeless import first_flight

Array = NDArray[np.float64]

#: Relative residual to which the stencil's part is solved.
CONVERGED = 1e-10


class ModifiedDiscreteOrdinates(DirectPropagator):
    """I = I_direct + I_rest (Ramankutty and Crosbie 1997, after Olfe 1970 and Modest 1989).

    I_direct, light on its first flight, is the closed form of the reference with black walls: that
    is where intensities jump and ordinates show as rays. I_rest is what walls send back, which is
    smooth; a stencil carries it. Each side of each element of a wall, `element` cells long at most,
    gets its exact irradiance and starts albedo times that as a Lambertian lobe half a cell in front
    of it, as an area light does (Kaplanyan and Dachsbacher 2010, 3.1); the stencil follows all
    further bounces. The published method is for participating media between black walls; all
    beyond the split is this project's.

    With black walls this is the reference, to the last digit.

    What it gets wrong: the share of the light that is reflected, times the error of the stencil. In
    a scene where a fifth of the field is reflected, DOM8 leaves 12 % and LPV 19 %, of the share by
    itself half and all of it; in `cornell-2d`, where a third is, 14 % and 32 %. `beam` and
    `light-propagation-maps` do better for less; this is for users of the stencils.
    """

    name = "modified-dom"
    summary = "first flight exact, bounces by a stencil"
    dimensions: ClassVar = (2,)
    options = (
        Option("scheme", str, "dom8", "the stencil: any propagator that steps, with its defaults"),
        Option(
            "element",
            float,
            0.5,
            "longest piece of a reflecting wall with one irradiance, in cells",
            minimum=0.01,
            maximum=1000.0,
        ),
        Option("bounces", bool, True, "walls send light back as their albedo says; else all black"),
    )

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field and its books; in the details the `residual` that the stencil reached.

        Raises what `Simulation.solve` raises.
        """
        self.require_dimension(scene.grid.dimension)
        stencil = self._stencil_scheme()
        problem = read_problem(scene, bands, self.values["element"], self.values["bounces"])
        direct, books = first_flight(problem.geometry, bands), balance(problem.geometry, True)
        if not problem.geometry.reflects:
            return problem.finished(direct, books, {"residual": 0.0})
        glow, lost = _glow(problem)
        simulation = Simulation(_lit_by(scene, glow), stencil, bands=bands)
        report = simulation.solve(CONVERGED)
        rest = np.asarray(simulation.accumulated.values).reshape(direct.shape)
        # What leaves the walls is on its way already, and no light of its own. What the solver has
        # not settled is still inside.
        sent = simulation.ledger
        rest_books = replace(
            sent,
            emitted=0 * lost,
            left=sent.left + lost,
            inside=sent.inside + sent.closure,
            reflected=sent.emitted + lost + sent.reflected,
        )
        total = weighted_sum([books, rest_books], [1.0, 1.0])
        return problem.finished(direct + rest, total, {"residual": report.residual})

    def _stencil_scheme(self) -> StencilPropagator:
        """Raises InputError for a name that is unknown or no stencil in 2D."""
        from propagators.registry import create, find, names

        name = self.values["scheme"]
        scheme = create(name)
        if not isinstance(scheme, StencilPropagator) or 2 not in scheme.dimensions:
            classes = {other: find(other) for other in names()}
            stepping = [
                other
                for other, found in classes.items()
                if issubclass(found, StencilPropagator) and 2 in found.dimensions
            ]
            raise bad_input("scheme", name, "does not step in 2D", stepping)
        return scheme


def _glow(problem: DirectProblem) -> tuple[Array, Array]:
    """What walls send back of the first flight, in cells (C, size, nx, ny), and what misses them.

    Flux (C,) that misses the grid starts beyond its border, half a cell in front of a wall.
    """
    geometry, basis, shape = problem.geometry, problem.basis, problem.shape
    reflecting = np.any(geometry.albedo[geometry.surfaces] > 0, axis=1)
    elements = cut_walls(geometry, problem.element, reflecting)
    sent = arriving_flux(geometry, elements.segments) * geometry.albedo[elements.owners]
    values, lost = np.zeros((problem.colours, basis.size, *shape)), np.zeros(problem.colours)
    for segment, flux in zip(elements.segments.reshape(-1, 2, 2), sent):
        along = (segment[1] - segment[0]) / np.hypot(*(segment[1] - segment[0]))
        normal = np.array([-along[1], along[0]])
        cuts, cells = cells_along(segment + 0.5 * normal, normal)
        lobe = basis.lambertian(normal)
        for cell, share in zip(cells, np.diff(cuts)):
            if np.all((cell >= 0) & (cell < shape)):
                values[:, :, cell[0], cell[1]] += share * flux[:, None] * lobe
            else:
                lost += share * flux
    return values, lost


def _lit_by(scene: Scene, glow: Array) -> Scene:
    """The scene with coefficients (C, size, nx, ny) for all its lights."""
    if not scene.colours:
        return scene.model_copy(update={"lights": (FileLight.of_values(glow[0]),)})
    pure = np.eye(len(glow))
    lights = [FileLight.of_values(*each) for each in zip(glow, map(tuple, pure.tolist()))]
    return scene.model_copy(update={"lights": tuple(lights)})
