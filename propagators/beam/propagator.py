"""Discrete ordinates with exact beams, as a propagator."""

from __future__ import annotations

import warnings
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import SchemeWarning, bad_input
from flatland.kernels.threads import thread_count
from flatland.ledger import Ledger
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.analytic.checks import checked_directions
from propagators.base import Answer, DirectPropagator, Option
from propagators.beam.solution import intensity_by_beams, solve_by_beams, solve_in_medium
from propagators.options import BOUNCES, ELEMENT
from propagators.transport.books import weighted_sum
from propagators.transport.ordinates import Ordinates, chosen_count
from propagators.transport.problem import DirectProblem, read_problem

Array = NDArray[np.float64]

#: Ordinates at which refinement gives up.
MOST_ORDINATES = 2**17


class Beam(DirectPropagator):
    """Discrete ordinates without a grid error: light is followed as whole beams (numerics §12).

    For each of M directions ω_k = 2π/M (k + 1/2), every surface that shines is cut into beams, each
    of which ends on one other surface; what a beam sends through the faces of each cell is exact.
    Then c = Σ_k 2π/M I(ω_k) y(ω_k). The only error is this quadrature in angle: the intensity that
    leaves a cell is continuous in angle, with kinks, so that the error falls with M⁻² once
    neighbouring ordinates from a light overlap in a cell: M > 2π D / (w + h) for a light of width w
    at the distance D in cells of size h. What each surface emits is scaled, by a factor
    1 + O(M⁻²), so that its flux is exact.

    ordinates=0 takes M = 4 N for N cells along the longest side, which keeps the error below 1 %
    in all built-in scenes with area lights. tolerance > 0 adds the ordinates halfway between those
    it has until the two sets differ so little that the error of both together is below it.

    Walls reflect diffusely, with a constant radiance on elements of at most `element` cells; what
    they send to one another travels along the same ordinates. Points and parallel light need no
    quadrature: their first flight is the closed form of the reference.

    In a medium beams fade exactly along each ray. What they lose to it and to walls is carried on,
    over all further collisions and bounces, by light propagation maps of 32 angles and 8 rays: that
    leaves 0.3 to 0.5 % and takes nearly all of the time. Points and parallel light start there, as
    an injector puts them into cells. `intensity` knows a vacuum only.

    What it gets wrong: below that M, light from a small or far source arrives as bright and dark
    fans (ray effects): the scene `corridor` shows them at 64 ordinates.
    """

    name = "beam"
    summary = "exact beams along discrete ordinates: no error in space, M⁻² in angle"
    dimensions: ClassVar = (2,)
    media: ClassVar = True
    options = (
        Option(
            "ordinates",
            int,
            0,
            "directions, a multiple of 4; 0: four for each cell along the longest side",
            minimum=0,
            maximum=MOST_ORDINATES,
        ),
        Option(
            "tolerance",
            float,
            0.0,
            "relative L2 error to refine to, by twice as many ordinates each time; 0: as they are",
            minimum=0.0,
            maximum=1.0,
        ),
        ELEMENT,
        BOUNCES,
    )

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field, its books, and in the details `ordinates` and, if refined, `error`.

        error: estimated relative L2 error of all coefficients (see `_refined`).
        """
        problem = self._problem(scene, bands)
        ordinates = Ordinates(chosen_count(self.values["ordinates"], scene.grid.shape, bands))
        values, ledger = self._solve(problem, ordinates)
        details: dict[str, float] = {"ordinates": ordinates.count}
        if self.values["tolerance"] > 0:
            values, ledger, details = self._refined(problem, ordinates, values, ledger)
        if scene.medium is not None:
            # Points and parallel light have no closed form there, and are among the values.
            return problem.finished(values, ledger, details)
        return problem.answer(values, ledger, details)

    def _solve(self, problem: DirectProblem, ordinates: Ordinates) -> tuple[Array, Ledger]:
        if problem.scene.medium is None:
            return solve_by_beams(problem, ordinates)
        return solve_in_medium(problem, ordinates)

    def intensity(self, scene: Scene, directions: ArrayLike) -> Array:
        """I ([colours,] K, nx, ny) [W/rad] of segment lights at unit directions (K, 2).

        Exact; what walls send back and lights without size are left out. Raises InputError in a
        medium.
        """
        if scene.medium is not None:
            rule = "fills the grid, and intensities by direction are those of a vacuum"
            raise bad_input("medium, extinction", scene.medium.extinction, rule, [0])
        problem = self._problem(scene, 1)
        values = intensity_by_beams(problem, checked_directions(directions))
        return values if scene.colours else values[0]

    def _problem(self, scene: Scene, bands: int) -> DirectProblem:
        self.require_scene(scene)
        element, bounces = self.values["element"], self.values["bounces"]
        problem = read_problem(scene, bands, element, bounces)
        # The ends of runs in each thread, and the field.
        lanes = problem.colours * problem.basis.size + 1
        needed = (2 * thread_count() + 2) * lanes * scene.grid.cell_count * 8
        require_memory(needed, "bands", bands)
        return problem

    def _refined(
        self, problem: DirectProblem, ordinates: Ordinates, values: Array, ledger: Ledger
    ) -> tuple[Array, Ledger, dict[str, float]]:
        """Both sets together until they agree.

        The error of M ordinates changes its sign, near enough, from a set to the one halfway
        between its ordinates, and that of both is a quarter as large: of the trapezoidal rule's
        leading term c/M², it has c/4 and their difference 3c/2, a sixth. A quarter of the
        difference is taken: below the M of ray effects the error falls more slowly.
        """
        tolerance, count, offset = self.values["tolerance"], ordinates.count, 0.0
        while True:
            other, books = self._solve(problem, Ordinates(count, offset))
            change = float(np.linalg.norm(other - values))
            values, ledger = 0.5 * (values + other), weighted_sum([ledger, books], [0.5, 0.5])
            rest = problem.sizeless_values if problem.scene.medium is None else 0.0
            size = float(np.linalg.norm(values + rest))
            error = 0.25 * change / size if size else 0.0
            count, offset = 2 * count, 0.5
            if error <= tolerance or count >= MOST_ORDINATES:
                break
        if error > tolerance:
            message = f"{self} reached an error of {error:.1e} only, with {count} ordinates"
            warnings.warn(message, SchemeWarning, stacklevel=4)
        return values, ledger, {"ordinates": count, "error": error}
