"""A scene solved by beams, for one set of ordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics
from flatland.ledger import Ledger
from propagators.analytic.geometry import Geometry
from propagators.beam.bounces import reflected_radiance
from propagators.beam.flight import Transport
from propagators.transport.arrangement import arrange
from propagators.transport.books import weighted_sum
from propagators.transport.ordinates import Ordinates
from propagators.transport.sizeless import SizelessLights
from propagators.transport.surface_elements import SurfaceElements, cut_elements

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BeamProblem:
    """What does not depend on the ordinates. element: longest one, in cells."""

    geometry: Geometry
    basis: CircularHarmonics
    element: float

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
        """What they send to each side of each element, (E, 2, C)."""
        surfaces = self.surfaces
        flux = np.zeros((surfaces.count, 2, surfaces.arrangement.colours))
        bright = np.flatnonzero(np.any(surfaces.albedo > 0, axis=1))
        if self.sizeless is not None and len(bright):
            segments = surfaces.segments[bright]
            flux[bright, 0] = self.sizeless.arriving(segments)
            flux[bright, 1] = self.sizeless.arriving(segments[:, [2, 3, 0, 1]])
        return flux

    @cached_property
    def sizeless_books(self) -> Ledger:
        return Ledger() if self.sizeless is None else self.sizeless.books()

    def solve(self, ordinates: Ordinates) -> tuple[Array, Ledger]:
        """Coefficients (C, size, nx, ny) and the books, entries (C,)."""
        surfaces, shape = self.surfaces, self.geometry.grid.shape
        transport = Transport(surfaces, ordinates, (shape[0], shape[1]))
        scale = ordinates.emission_scale(surfaces.arrangement.segments)[surfaces.owners]
        radiance = surfaces.radiance * scale[:, None, None]
        if surfaces.arrangement.reflects:
            direct = transport.fly(radiance, None)
            arrived = direct.arrived + self.sizeless_flux
            emitted = direct.emitted
            radiance = radiance + reflected_radiance(transport, scale, arrived)
            flight = transport.fly(radiance, self.basis)
        else:
            flight = transport.fly(radiance, self.basis)
            emitted = flight.emitted
        kept = np.einsum("esc,ec->c", flight.arrived, 1 - surfaces.albedo)
        zero = np.zeros_like(kept)
        books = Ledger(emitted, flight.left, kept, zero, zero, flight.emitted - emitted)
        return flight.values + self.sizeless_values, weighted_sum(
            [books, self.sizeless_books], [1.0, 1.0]
        )

    def intensity(self, directions: Array) -> Array:
        """Intensity (C, K, nx, ny) of the segment lights at directions (K, 2), one by one."""
        shape = self.geometry.grid.shape
        transport = Transport(self.surfaces, Ordinates(4), (shape[0], shape[1]))
        values = [transport.along(direction, self.surfaces.radiance) for direction in directions]
        return (
            np.array(values).reshape(-1, self.surfaces.arrangement.colours, *shape).swapaxes(0, 1)
        )
