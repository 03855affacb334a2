"""A scene as the schemes read it that follow light from surface to surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from flatland.harmonics import CircularHarmonics
from flatland.injection import inject
from flatland.ledger import Ledger
from flatland.occlusion import without_first_bounces
from flatland.scene import Scene
from flatland.sources import SegmentSource
from propagators.analytic.geometry import Geometry, read_geometry
from propagators.base import Answer
from propagators.transport.arrangement import arrange
from propagators.transport.books import by_colour, weighted_sum
from propagators.transport.sizeless import SizelessLights
from propagators.transport.surface_elements import SurfaceElements, cut_elements

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DirectProblem:
    """Everything that does not depend on how light is followed. element: longest one, in cells."""

    scene: Scene
    geometry: Geometry
    basis: CircularHarmonics
    element: float

    @property
    def shape(self) -> tuple[int, int]:
        nx, ny = self.geometry.grid.shape
        return nx, ny

    @property
    def colours(self) -> int:
        """At least 1."""
        return self.geometry.radiance.shape[1]

    @cached_property
    def surfaces(self) -> SurfaceElements:
        return cut_elements(arrange(self.geometry), self.element)

    @cached_property
    def sizeless(self) -> SizelessLights | None:
        return SizelessLights.of(self.geometry)

    @cached_property
    def sizeless_values(self) -> Array | float:
        """What leaves the cells of points and parallel light alone."""
        return 0.0 if self.sizeless is None else self.sizeless.field(self.basis.bands)

    @cached_property
    def sizeless_flux(self) -> Array:
        """What they send to each side of each reflecting element, (E, 2, C)."""
        surfaces = self.surfaces
        flux = np.zeros((surfaces.count, 2, self.colours))
        bright = np.flatnonzero(np.any(surfaces.albedo > 0, axis=1))
        if self.sizeless is not None and len(bright):
            segments = surfaces.segments[bright]
            flux[bright, 0] = self.sizeless.arriving(segments)
            flux[bright, 1] = self.sizeless.arriving(segments[:, [2, 3, 0, 1]])
        return flux

    @property
    def light_flux(self) -> Array:
        """What all segment lights emit inside the grid, (C,)."""
        return np.asarray(2 * np.einsum("e,esc->c", self.surfaces.lengths, self.surfaces.radiance))

    def books(
        self,
        emitted: Array,
        reflected: Array,
        left: Array,
        arrived: Array,
        created: Array | None = None,
        collided: Array | None = None,
        scattered: Array | None = None,
    ) -> Ledger:
        """Ledger of a flight, entries (C,), with that of the lights without size.

        emitted: by lights with a size. reflected: sent by walls. left: over the border, of both.
        arrived: (E, 2, C), of both. What walls have received but not sent yet is `inside`. created:
        what a scheme knows that it adds; None if it only knows that the books must close. collided,
        scattered: (C,), flux that met the medium, and what of it was sent on.
        """
        walls = self.surfaces.albedo
        kept = np.einsum("esc,ec->c", arrived, 1 - walls)
        inside = np.einsum("esc,ec->c", arrived + self.sizeless_flux, walls) - reflected
        lit = np.einsum("esc,ec->c", self.sizeless_flux, walls)
        if created is None:
            created = left + kept + inside - lit - emitted
        books = Ledger(emitted, left, kept, inside, created, reflected)
        if collided is not None and scattered is not None and self.scene.medium is not None:
            albedo = self.scene.medium.albedo
            books.medium = (1 - albedo) * collided
            books.inside = inside + albedo * collided - scattered
        if self.sizeless is None:
            return books
        return weighted_sum([books, self.sizeless.books()], [1.0, 1.0])

    def answer(self, values: Array, ledger: Ledger | None, details: dict[str, float]) -> Answer:
        """From coefficients (C, size, nx, ny) of segment lights and walls, and entries (C,)."""
        return self.finished(values + self.sizeless_values, ledger, details)

    def finished(self, values: Array, ledger: Ledger | None, details: dict[str, float]) -> Answer:
        """From coefficients (C, size, nx, ny) of all light, and entries (C,)."""
        coloured = self.scene.colours > 0
        field = Field(self.scene.grid, self.basis, values if coloured else values[0])
        return Answer(field, None if ledger is None else by_colour(ledger, coloured), details)

    def of_segments_only(self) -> tuple[DirectProblem, Array]:
        """The same without points and parallel light, and what they put into cells.

        Coefficients (C, size, nx, ny), spread over cells as an injector does it: for a medium,
        where their closed form does not hold.
        """
        geometry = replace(self.geometry, positions=np.empty((0, 2)), directions=np.empty((0, 2)))
        scene = without_first_bounces(self.scene)
        walls = scene.walls()
        kept = tuple(
            light
            for light in scene.lights
            if not all(
                isinstance(twin, SegmentSource)
                for twin in light.twins(scene.grid, walls, scene.colours, "lamp")
            )
        )
        values = inject(scene.model_copy(update={"lights": kept}), self.basis).values
        shape = (self.colours, self.basis.size, *self.shape)
        cells = np.broadcast_to(np.asarray(values, float), shape)
        return replace(self, geometry=geometry), cells


def read_problem(scene: Scene, bands: int, element: float, bounces: bool) -> DirectProblem:
    """Raises InputError for what `read_geometry` refuses, for bad bands and for opaque cells."""
    if scene.medium is not None:
        scene.medium.require_passable(scene.medium.extinction * scene.grid.spacing)
    geometry = read_geometry(scene)
    if not bounces:
        geometry = replace(geometry, albedo=np.zeros_like(geometry.albedo))
    return DirectProblem(scene, geometry, CircularHarmonics(bands), element)
