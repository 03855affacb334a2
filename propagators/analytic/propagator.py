"""The exact answer to a scene, as a propagator."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.ledger import Ledger
from flatland.scene import Scene
from propagators.analytic.arcs import Arc
from propagators.analytic.flat import FlatAnswer
from propagators.analytic.irradiance import SurfaceLight
from propagators.base import Option, Propagator
from propagators.options import BOUNCES, element_of_one
from propagators.watching import Progress

if TYPE_CHECKING:
    from propagators.analytic_3d.answer import VolumeAnswer
    from propagators.analytic_3d.irradiance import FacetLight

Array = NDArray[np.float64]


class Analytic(Propagator):
    """The reference: what leaves each cell, exactly in angle.

    I_ref(ω) = ∫_{∂cell, n·ω>0} L(x, ω) (n·ω) dA (numerics §1).

    Lights are Lambertian segments (2D) or polygons (3D), opaque from both sides and black, points,
    and parallel light. Light that arrives at a face on which a wall lies counts as outflow of the
    cell it comes from; light that starts there is no outflow of the cell behind. Parallel light
    comes in from outside past what lies in the grid and on its border, except for area lights on
    the border: they stand for the surroundings, such as a sky. Where occluders have an albedo, both
    their sides reflect diffusely, any number of times. Only what lies in the grid reflects.

    In 2D, closed form in angle and in space. Between the places where edges of segments line up,
    what a face sees of an emitter is bounded by two edges, and its harmonics are a sum over four
    strings (`strings`; Hottel 1954 for band 0). There is nothing to refine: the error is rounding,
    about 1e-13 of the largest coefficient, at any number of bands. Bounces are radiosity
    (`radiosity`; Goral et al. 1984) on elements of at most `element` cells.

    In 3D, closed form in angle: at a point of a face, walls take their shadows out of an emitter,
    and the harmonics of the convex pieces left are sums over their edges (`analytic_3d.flow`). Over
    a face that is integrated by Gauss rules on panels, split where walls and planes of lights meet
    them and cut adaptively until the field meets `tolerance`. Points and parallel light are exact.
    Bounces are radiosity between elements that lines through the scene connect; the same kind of
    lines carries what elements send through cells (`analytic_3d.radiosity`, `analytic_3d.cells`),
    as many as `tolerance` asks for.

    What it gets wrong: a reflecting wall's radiance is constant on an element: `bounce_error`
    measures that. Geometry is exact to 1e-10 cells: nearer things touch. In 2D, a light shorter
    than 1e-5 cells therefore loses digits in its penumbrae (1e-9 of its flux at 1e-8 cells). In 3D
    the error estimate for direct light can miss a shadow much narrower than half a cell, and that
    for bounces is one of two random answers: it scatters by a few per cent of itself.
    """

    name = "analytic"
    summary = "the exact answer: crossed strings in 2D, spherical polygons in 3D"
    dimensions: ClassVar = (2, 3)
    options = (
        element_of_one("radiosity"),
        BOUNCES,
        Option(
            "tolerance",
            float,
            1e-3,
            "relative L2 error of a field in 3D, elements apart; 2D is exact",
            minimum=1e-8,
            maximum=0.1,
        ),
    )

    def solve(
        self,
        scene: Scene,
        bands: int,
        tolerance: float = 1e-8,
        progress: Progress | None = None,
    ) -> Field:
        """The exact field, coefficients ([colours,] size, nx, ny[, nz]).

        tolerance is there for the common signature: in 2D the closed form meets any that float64
        can, in 3D the option of that name counts. Where walls reflect, `element` sets an error of
        its own. progress: called with the share done; by default, whoever watches is
        (`propagators.watching`).
        Raises ConvergenceError where light between walls never ends, or takes too many lines.
        """
        return self._answer(scene, progress).field(bands)

    def bounce_error(self, scene: Scene, bands: int) -> float:
        """Relative L2 change of the field when `element` is halved; 0 where nothing reflects.

        The error falls with the second power of the element, so that of `solve` is about 4/3 of
        this. Costs a few times an answer. In 3D lines scatter it by up to a few 1e-4.
        """
        return self._answer(scene).bounce_error(bands)

    def intensity(self, scene: Scene, directions: ArrayLike) -> Array:
        """I_ref ([colours,] K, *shape) [W/rad or W/sr] at unit directions (K, dimension).

        Not band-limited. A point source counts, in full, in the cells whose border its ray
        crosses. Parallel light is left out: its intensity is infinite in one direction and zero in
        all others. Exact in space but for what walls reflect in 3D: lines an eighth of a cell apart
        sample that, to about 1 % per cell and direction.
        """
        return self._answer(scene).intensity(directions)

    def arcs(self, scene: Scene, point: ArrayLike) -> list[Arc]:
        """Light of segments at a world point (2,), as arcs of directions of travel. 2D only.

        Lights and, where walls reflect, one arc for every element of a wall that is seen.
        """
        if scene.grid.dimension != 2:
            raise bad_input("scene", scene.grid.shape, "arcs are there in 2D only")
        self.require_scene(scene)
        return self._flat(scene).arcs(point)

    def irradiance(self, scene: Scene) -> SurfaceLight | FacetLight:
        """Mean irradiance of both sides of all walls, in pieces of at most `element` cells.

        In 2D pieces are shorter where walls meet and end where they cross and where shadows of
        points and parallel light end. What lies outside the grid or on an earlier wall is left out.
        """
        return self._answer(scene).irradiance()

    def irradiance_at(self, scene: Scene, points: ArrayLike, normals: ArrayLike) -> Array:
        """Irradiance ([colours,] K) [W/m or W/m²] at points (K, dimension) [m] of surfaces.

        Points may lie on walls: the unit normal (K, dimension) says on which side. Exact, for the
        radiosity that elements have.
        """
        return self._answer(scene).irradiance_at(points, normals)

    def energy(self, scene: Scene) -> Ledger:
        """Flux [W] emitted, left over the border and absorbed by walls, () or (colours,).

        Over whole walls, apart from cells and bands, so that the closure of these books checks the
        geometry: to rounding in 2D, to about `tolerance` in 3D. Reflected light closes them at any
        `element`.
        """
        return self._answer(scene).energy()

    def absorbed(self, scene: Scene) -> Array:
        """Flux ([colours,] S) [W] that both sides of each of the scene's walls absorb."""
        return self._answer(scene).absorbed()

    def _answer(self, scene: Scene, progress: Progress | None = None) -> FlatAnswer | VolumeAnswer:
        self.require_scene(scene)
        if scene.grid.dimension == 2:
            return self._flat(scene, progress)
        from propagators.analytic_3d.answer import VolumeAnswer

        return VolumeAnswer(scene, **self.values, progress=progress)

    def _flat(self, scene: Scene, progress: Progress | None = None) -> FlatAnswer:
        return FlatAnswer(scene, self.values["element"], self.values["bounces"], progress)
