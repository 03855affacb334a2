"""Modified discrete ordinates: the first flight exact, everything after it by a stencil."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.injectors.file import FileLight
from flatland.ledger import Ledger
from flatland.moved_segments import cells_along
from flatland.scene import Scene
from flatland.simulation import Simulation
from propagators.analytic.balance import arriving_flux, balance
from propagators.analytic.elements import cut_walls
from propagators.base import Answer, DirectPropagator, Option, StencilPropagator
from propagators.beam.solution import first_flight_through
from propagators.options import BOUNCES, element_of_one
from propagators.transport.books import weighted_sum
from propagators.transport.ordinates import Ordinates, chosen_count
from propagators.transport.problem import DirectProblem, read_problem
from propagators.transport.sizeless import first_flight

Array = NDArray[np.float64]

#: Relative residual to which the stencil's part is solved.
CONVERGED = 1e-10
#: Ordinates for each cell along the longest side of a first flight through a medium.
ORDINATES_PER_CELL = 16


class ModifiedDiscreteOrdinates(DirectPropagator):
    """I = I_direct + I_rest (Ramankutty and Crosbie 1997, after Olfe 1970 and Modest 1989).

    I_direct, light on its first flight, is the closed form of the reference with black walls: that
    is where intensities jump and ordinates show as rays. I_rest is what walls send back, which is
    smooth; a stencil carries it. Each side of each element of a wall, `element` cells long at most,
    gets its exact irradiance and starts albedo times that as a Lambertian lobe half a cell in front
    of it, as an area light does (Kaplanyan and Dachsbacher 2010, 3.1); the stencil follows all
    further bounces. The published method is for participating media between black walls; all
    beyond the split is this project's.

    With black walls this is the reference, to the last digit (numerics §12). In a medium the first
    flight is that of exact beams, and a cell also starts what its collisions scatter, in all
    directions alike.

    What it gets wrong: the share of the light that is reflected, times the error of the stencil. In
    a scene where a fifth of the field is reflected, DOM8 leaves 12 % and LPV 19 %, of the share by
    itself half and all of it; in `cornell-2d`, where a third is, 14 % and 32 %. `beam` and
    `light-propagation-maps` do better for less; this is for users of the stencils.
    """

    name = "modified-dom"
    summary = "first flight exact, bounces by a stencil"
    dimensions: ClassVar = (2,)
    media: ClassVar = True
    options = (
        Option("scheme", str, "dom8", "the stencil: any propagator that steps, with its defaults"),
        element_of_one("irradiance"),
        BOUNCES,
    )

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field and its books; in the details the `residual` that the stencil reached.

        Raises what `Simulation.solve` raises.
        """
        self.require_scene(scene)
        stencil = self._stencil_scheme()
        element, bounces = self.values["element"], self.values["bounces"]
        problem = read_problem(scene, bands, element, bounces)
        first = _in_vacuum(problem) if scene.medium is None else _in_medium(problem)
        if not np.any(first.start):
            return problem.finished(first.values, first.books, {"residual": 0.0})
        simulation = Simulation(_lit_by(scene, first.start), stencil, bands=bands)
        report = simulation.solve(CONVERGED)
        rest = np.asarray(simulation.accumulated.values).reshape(first.values.shape)
        # What leaves walls and collisions is on its way already, and no light of its own. What the
        # solver has not settled is still inside.
        sent = simulation.ledger
        rest_books = replace(sent, emitted=0 * sent.emitted, inside=sent.inside + sent.closure)
        total = weighted_sum([first.books, rest_books], [1.0, 1.0])
        return problem.finished(first.values + rest, total, {"residual": report.residual})

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


class _FirstFlight(NamedTuple):
    """values: coefficients (C, size, nx, ny) of what leaves cells. start: the same of what goes on

    from cells, for the stencil. books: entries (C,), without what goes on.
    """

    values: Array
    start: Array
    books: Ledger


def _in_vacuum(problem: DirectProblem) -> _FirstFlight:
    """In closed form."""
    geometry = problem.geometry
    direct, books = first_flight(geometry, problem.basis.bands), balance(geometry, True)
    if not geometry.reflects:
        return _FirstFlight(direct, np.zeros_like(direct), books)
    reflecting = np.any(geometry.albedo[geometry.surfaces] > 0, axis=1)
    elements = cut_walls(geometry, problem.element, reflecting)
    sent = arriving_flux(geometry, elements.segments) * geometry.albedo[elements.owners]
    start, lost = glow(problem, elements.segments, sent)
    books = weighted_sum([books, Ledger(left=lost, reflected=sent.sum(axis=0))], [1.0, 1.0])
    return _FirstFlight(direct, start, books)


def _in_medium(problem: DirectProblem) -> _FirstFlight:
    """By exact beams, as many as the closed form would need to be as good as a stencil's rest."""
    medium = problem.scene.medium
    assert medium is not None
    cells: Array | float = 0.0
    emitted = problem.light_flux
    if problem.sizeless is not None:
        problem, cells = problem.of_segments_only()
        emitted = emitted + cells[:, 0].sum(axis=(1, 2)) * problem.basis.flux_weight
    count = chosen_count(0, problem.shape, problem.basis.bands, ORDINATES_PER_CELL)
    flight = first_flight_through(problem, Ordinates(count))
    albedo, segments = problem.surfaces.albedo, problem.surfaces.segments
    both = np.concatenate([segments, segments[:, [2, 3, 0, 1]]])
    sent = np.concatenate([albedo * flight.arrived[:, side] for side in (0, 1)])
    bright = np.any(sent > 0, axis=1)
    start, lost = glow(problem, both[bright], sent[bright])
    start += cells
    start[:, 0] += medium.albedo * flight.collided / problem.basis.flux_weight
    kept = np.einsum("esc,ec->c", flight.arrived, 1 - albedo)
    absorbed = (1 - medium.albedo) * flight.collided.sum(axis=(1, 2))
    zero = np.zeros_like(kept)
    left = flight.left + lost
    books = Ledger(emitted, left, kept, zero, zero, sent.sum(axis=0), absorbed)
    return _FirstFlight(flight.values, start, books)


def glow(problem: DirectProblem, segments: Array, sent: Array) -> tuple[Array, Array]:
    """Flux (K, C) that the left of segments (K, 4) sends, in cells (C, size, nx, ny), and what
    misses them.

    Each is moved by half a cell to its left and cut at cell borders; flux (C,) that then lies
    outside the grid misses it.
    """
    basis, shape = problem.basis, problem.shape
    values, lost = np.zeros((problem.colours, basis.size, *shape)), np.zeros(problem.colours)
    for segment, flux in zip(segments.reshape(-1, 2, 2), sent):
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
