"""What the analytic reference answers about one 2D scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.field import Field
from flatland.harmonics import CircularHarmonics
from flatland.ledger import Ledger
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.analytic.arcs import Arc, visible_arcs
from propagators.analytic.balance import absorbed_flux, arriving_flux, balance
from propagators.analytic.beams import beam_intensity, ray_intensity
from propagators.analytic.checks import (
    checked_directions,
    checked_points,
    checked_surfaces,
    per_colour,
)
from propagators.analytic.elements import cut_walls
from propagators.analytic.geometry import Geometry, read_geometry
from propagators.analytic.irradiance import SurfaceLight, irradiance_at
from propagators.analytic.lighting import collect_all
from propagators.analytic.radiosity import Bounced, all_emitters, bounce
from propagators.watching import Progress, watcher

Array = NDArray[np.float64]

#: Share of the work on a field that is done once walls know what they send back.
_BOUNCES = 0.1


class FlatAnswer:
    """Closed form in angle and in space (see `Analytic`). element: cells; bounces: see there.

    progress: gets the share done; by default, whoever watches does.
    """

    def __init__(
        self, scene: Scene, element: float, bounces: bool, progress: Progress | None = None
    ) -> None:
        self.scene, self.element, self.bounces = scene, element, bounces
        self._report = progress or watcher()

    def field(self, bands: int) -> Field:
        return self._field(bands, self.element)

    def bounce_error(self, bands: int) -> float:
        if not (self.bounces and read_geometry(self.scene).reflects):
            return 0.0
        coarse, fine = (
            self._field(bands, size).values for size in (self.element, self.element / 2)
        )
        norm = float(np.linalg.norm(fine))
        return float(np.linalg.norm(coarse - fine)) / norm if norm else 0.0

    def intensity(self, directions: ArrayLike) -> Array:
        geometry, bounced = self._read()
        unit = checked_directions(directions)
        shape = self.scene.grid.shape[0], self.scene.grid.shape[1]
        emitters, radiance = all_emitters(geometry, bounced)
        values = beam_intensity(shape, unit, emitters, radiance, geometry.walls)
        if len(geometry.positions):
            strength = geometry.point_intensity(unit)
            values += ray_intensity(shape, unit, geometry.positions, strength, geometry.walls)
        return per_colour(self.scene, np.ascontiguousarray(np.moveaxis(values, 1, 0)))

    def arcs(self, point: ArrayLike) -> list[Arc]:
        geometry, bounced = self._read()
        x, y = geometry.in_cells(checked_points("point", point, (2,)))
        emitters, radiance = all_emitters(geometry, bounced)
        # Places in scene.sources("lamp"), then -1 - places in scene.segments().
        origins = geometry.emitter_sources
        if bounced is not None:
            places = bounced.elements.owners - len(geometry.emitters)
            origins = np.concatenate([origins, -1 - places])
        radiance = radiance / self.scene.grid.spacing
        return [
            Arc(
                float(start),
                float(stop),
                radiance[int(e)] if self.scene.colours else float(radiance[int(e), 0]),
                int(origins[int(e)]),
            )
            for start, stop, e in visible_arcs(x, y, emitters, geometry.walls)
        ]

    def irradiance(self) -> SurfaceLight:
        geometry, bounced = self._read()
        grid, lights = self.scene.grid, len(geometry.emitters)
        elements = cut_walls(geometry, self.element, geometry.surfaces >= lights)
        flux = arriving_flux(geometry, elements.segments, bounced)
        mean = flux / (elements.lengths[:, None] * grid.spacing)
        ends = grid.to_world(elements.segments.reshape(-1, 2, 2))
        values = per_colour(self.scene, mean.T)
        return SurfaceLight(elements.owners - lights, ends[:, 0], ends[:, 1], values)

    def irradiance_at(self, points: ArrayLike, normals: ArrayLike) -> Array:
        geometry, bounced = self._read()
        places, unit = checked_surfaces(points, normals, 2)
        cells = np.array([geometry.in_cells(place) for place in places]).reshape(-1, 2)
        values = irradiance_at(geometry, cells, unit, *all_emitters(geometry, bounced))
        return per_colour(self.scene, values.T / self.scene.grid.spacing)

    def energy(self) -> Ledger:
        geometry, bounced = self._read()
        return balance(geometry, self.scene.colours > 0, bounced)

    def absorbed(self) -> Array:
        geometry, bounced = self._read()
        flux = absorbed_flux(geometry, bounced)[len(geometry.emitters) :]
        return per_colour(self.scene, flux.T)

    def _field(self, bands: int, element: float) -> Field:
        self._report(0.0)
        geometry, bounced = self._read(element)
        grid, basis = self.scene.grid, CircularHarmonics(bands)
        colours = geometry.radiance.shape[1]
        # Outlines of cells, moments, and their copy with the colours and coefficients first.
        needed = grid.cell_count * (16 + 2 * colours * basis.size) * 8
        require_memory(needed, "bands", bands)
        outlines = geometry.cell_outlines()
        moments = collect_all(geometry, outlines, basis.bands, bounced, self._after_bounces)
        self._report(1.0)
        moments /= np.where(basis.degrees > 0, np.sqrt(np.pi), np.sqrt(2 * np.pi))
        values = moments.reshape(*grid.shape, colours, basis.size).transpose(2, 3, 0, 1)
        return Field(grid, basis, per_colour(self.scene, np.ascontiguousarray(values)))

    def _after_bounces(self, share: float) -> None:
        self._report(_BOUNCES + (1 - _BOUNCES) * share)

    def _read(self, element: float = 0.0) -> tuple[Geometry, Bounced | None]:
        """The scene's arrays and, if anything reflects, what its walls send back."""
        geometry = read_geometry(self.scene)
        if not self.bounces:
            geometry = replace(geometry, albedo=np.zeros_like(geometry.albedo))
        return geometry, bounce(geometry, element or self.element) if geometry.reflects else None
