"""Light propagation maps, as a propagator."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.errors import SchemeWarning
from flatland.injection import inject
from flatland.kernels.threads import thread_count
from flatland.memory import require_memory
from flatland.occlusion import without_first_bounces
from flatland.scene import Scene
from propagators.base import Answer, DirectPropagator, Option
from propagators.maps.flight import Maps
from propagators.maps.generations import settled_light
from propagators.options import BOUNCES, ELEMENT
from propagators.transport.problem import DirectProblem, read_problem

Array = NDArray[np.float64]


class LightPropagationMaps(DirectPropagator):
    """Light propagation maps (Fattal 2009), in 2D and with surfaces (numerics §12).

    Four maps, one for each axis, each with M angles over ±45° round it; for each angle rays cross
    the grid at a distance of 1/K cells, K of them for each cell across, at exact places: light is
    not mixed on its way. A ray carries flux L (sin b - sin a)/K, [a, b] the bin it stands for, and
    books it in every cell that it leaves, with the cosine-weighted mean of y over the bin. It gives
    up what it carries to the first segment it meets, and takes on what that sends. What a side of a
    light sends is scaled once, for all rays together, so that its flux is exact.

    Walls reflect diffusely, with one radiance on each element of at most `element` cells; rays
    carry light between them until it settles. In a medium rays fade along each chord, and what
    collides in a cell is scattered from all of it alike. Points and parallel light make their first
    flight in closed form; in a medium they start as an injector puts them into cells.
    source="cell" takes instead what an injector puts into cells, of any kind of light, spread
    evenly over the cell; area lights do not block then.

    Fattal's maps serve participating media and hold rays on a lattice of cells; equal angles,
    offsets, exact segments, the scaling and the booking of what leaves are this project's.

    What it gets wrong: ray effects, as many directions as there are: a small light far away needs
    more angles, distance over length times a few (`corridor`). Shadows are sampled at K rays a
    cell: the error falls with 1/K, keep K ≥ M/4. source="cell" forgets where in the cell a light
    is: 0.1 to 0.4 are left, however fine (`fig5-one-light`). In a medium, scattering from whole
    cells spreads light over 1 + (σ_t h)²/6 of the mean square distance; above 5 % it warns.
    """

    name = "light-propagation-maps"
    summary = "parallel rays at exact places, in four maps of angles, from surface to surface"
    dimensions: ClassVar = (2,)
    media: ClassVar = True
    options = (
        Option("angles", int, 32, "directions of each of the 4 maps", minimum=1, maximum=2**15),
        Option("rays", int, 8, "rays of each direction for each cell", minimum=1, maximum=4096),
        Option(
            "source",
            str,
            "segment",
            "lights as they are, or as an injector puts them into cells",
            ("segment", "cell"),
        ),
        ELEMENT,
        BOUNCES,
    )

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field, its books, and in the details `directions`."""
        self.require_scene(scene)
        values = self.values
        problem = read_problem(scene, bands, values["element"], values["bounces"])
        lanes = (thread_count() + 2) * problem.colours * problem.basis.size
        require_memory(lanes * scene.grid.cell_count * 8, "bands", bands)
        maps, emitted, cells = self._sources(problem)
        found = settled_light(maps, cells, maps.problem.sizeless_flux)
        _warn_of(maps.missed, emitted)
        # Walls that no ray meets from behind keep what comes to them.
        unsent = np.where(maps.passed > 0, 0.0, found.sent).sum(axis=(0, 1))
        books = maps.problem.books(
            emitted,
            found.sent.sum(axis=(0, 1)),
            found.tally.left,
            found.tally.arrived,
            -maps.missed - unsent,
            found.tally.collided.sum(axis=(0, 1)),
            found.scattered.sum(axis=(1, 2)),
        )
        return maps.problem.answer(found.values, books, {"directions": 4 * values["angles"]})

    def _sources(self, problem: DirectProblem) -> tuple[Maps, Array, Array | None]:
        """Maps, the flux (C,) of all lights that they follow, and what cells send of it.

        Coefficients (C, size, nx, ny), or None.
        """
        parameters = self.values["angles"], self.values["rays"]
        if self.values["source"] == "cell":
            scene = without_first_bounces(problem.scene)
            injected = np.asarray(inject(scene, problem.basis).values, float)
            cells = injected.reshape(problem.colours, problem.basis.size, *problem.shape)
            geometry = replace(
                problem.geometry,
                radiance=np.zeros_like(problem.geometry.radiance),
                positions=np.empty((0, 2)),
                directions=np.empty((0, 2)),
            )
            dark = replace(problem, geometry=geometry)
            return Maps(dark, *parameters, lights_block=False), _flux(cells, problem), cells
        if problem.scene.medium is None or problem.sizeless is None:
            return Maps(problem, *parameters), problem.light_flux, None
        segments, cells = problem.of_segments_only()
        return Maps(segments, *parameters), problem.light_flux + _flux(cells, problem), cells


def _flux(cells: Array, problem: DirectProblem) -> Array:
    return np.asarray(cells[:, 0].sum(axis=(1, 2)) * problem.basis.flux_weight)


def _warn_of(missed: Array, emitted: Array) -> None:
    """One SchemeWarning if some light met no ray at all."""
    share = float(np.sum(missed)) / float(np.sum(emitted)) if np.any(missed) else 0.0
    if abs(share) > 1e-12:
        message = (
            f"{share:.1e} of the light comes from surfaces that no ray meets, and is missing; "
            "more angles or rays find them"
        )
        warnings.warn(message, SchemeWarning, stacklevel=4)
