"""The exact answer for flat scenes, as a propagator."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.harmonics import CircularHarmonics
from flatland.ledger import Ledger
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.analytic.arcs import Arc, visible_arcs
from propagators.analytic.balance import absorbed_flux, arriving_flux, balance
from propagators.analytic.beams import beam_intensity, ray_intensity
from propagators.analytic.checks import checked_directions, checked_points
from propagators.analytic.elements import cut_walls
from propagators.analytic.geometry import Geometry, read_geometry
from propagators.analytic.irradiance import SurfaceLight, irradiance_at
from propagators.analytic.lighting import collect_all
from propagators.analytic.radiosity import Bounced, all_emitters, bounce
from propagators.base import Option, Propagator

Array = NDArray[np.float64]


class Analytic(Propagator):
    """The reference in 2D: what leaves each cell, in closed form in angle and in space.

    I_ref(ω) = ∫_{∂cell, n·ω>0} L(x, ω) (n·ω) dA (numerics §1). Between the places where edges of
    segments line up, what a face sees of an emitter is bounded by two edges, and its harmonics
    are a sum over four strings (`strings`; Hottel 1954 for band 0). There is nothing to refine:
    the error is rounding, about 1e-13 of the largest coefficient, at any number of bands.

    Lights are Lambertian segments, opaque from both sides and black, points, and parallel light.
    Light that arrives at a face on which a segment lies counts as outflow of the cell it comes
    from; light that starts there is no outflow of the cell behind. Parallel light comes in from
    outside past what lies in the grid and on its border, except for segment lights on the border:
    they stand for the surroundings, such as a sky.

    Where occluders have an albedo, both their sides reflect diffusely, any number of times: what
    they send is found by radiosity (`radiosity`; Goral et al. 1984) on elements of at most
    `element` cells and then treated like any other emitter. Only what lies in the grid reflects.

    What it gets wrong: a reflecting wall's radiance is constant on an element, the one error that
    is not rounding: `bounce_error` measures it. Geometry is exact to 1e-10 cells: nearer things
    touch. A light shorter than 1e-5 cells therefore loses digits in its penumbrae (1e-9 of its
    flux at 1e-8 cells).
    """

    name = "analytic"
    summary = "the exact answer in 2D: visible arcs and crossed strings"
    dimensions: ClassVar = (2,)
    options = (
        Option(
            "element",
            float,
            0.5,
            "longest piece of a reflecting wall with one radiosity, in cells",
            minimum=0.01,
            maximum=1000.0,
        ),
        Option("bounces", bool, True, "walls send light back as their albedo says; else all black"),
    )

    def solve(self, scene: Scene, bands: int, tolerance: float = 1e-8) -> Field:
        """The exact field, coefficients ([colours,] size, nx, ny).

        tolerance is there for the common signature: the closed form meets any that float64 can.
        Where walls reflect, `element` sets the error instead.
        """
        return self._field(scene, bands, self.values["element"])

    def bounce_error(self, scene: Scene, bands: int) -> float:
        """Relative L2 change of the field when `element` is halved; 0 where nothing reflects.

        The error falls with the second power of the element, so that of `solve` is about 4/3 of
        this. Costs about three times an answer.
        """
        self.require_dimension(scene.grid.dimension)
        if not (self.values["bounces"] and read_geometry(scene).reflects):
            return 0.0
        size = self.values["element"]
        coarse, fine = (self._field(scene, bands, each).values for each in (size, size / 2))
        norm = float(np.linalg.norm(fine))
        return float(np.linalg.norm(coarse - fine)) / norm if norm else 0.0

    def intensity(self, scene: Scene, directions: ArrayLike) -> Array:
        """I_ref ([colours,] K, nx, ny) [W/rad] at unit directions (K, 2), not band-limited.

        A point source counts, in full, in the cells whose border its ray crosses. Parallel light
        is left out: its intensity is infinite in one direction and zero in all others.
        """
        geometry, bounced = self._read(scene)
        unit = checked_directions(directions)
        shape = scene.grid.shape[0], scene.grid.shape[1]
        emitters, radiance = all_emitters(geometry, bounced)
        values = beam_intensity(shape, unit, emitters, radiance, geometry.walls)
        if len(geometry.positions):
            strength = geometry.point_intensity(unit)
            values += ray_intensity(shape, unit, geometry.positions, strength, geometry.walls)
        return _per_colour(scene, np.ascontiguousarray(np.moveaxis(values, 1, 0)))

    def arcs(self, scene: Scene, point: ArrayLike) -> list[Arc]:
        """Light of segments at a world point (2,), as arcs of directions of travel.

        Lights and, where walls reflect, one arc for every element of a wall that is seen.
        """
        geometry, bounced = self._read(scene)
        x, y = geometry.in_cells(checked_points("point", point, (2,)))
        emitters, radiance = all_emitters(geometry, bounced)
        # Places in scene.sources("lamp"), then -1 - places in scene.segments().
        origins = geometry.emitter_sources
        if bounced is not None:
            places = bounced.elements.owners - len(geometry.emitters)
            origins = np.concatenate([origins, -1 - places])
        radiance = radiance / scene.grid.spacing
        return [
            Arc(
                float(start),
                float(stop),
                radiance[int(e)] if scene.colours else float(radiance[int(e), 0]),
                int(origins[int(e)]),
            )
            for start, stop, e in visible_arcs(x, y, emitters, geometry.walls)
        ]

    def irradiance(self, scene: Scene) -> SurfaceLight:
        """Mean irradiance of both sides of all scene.segments(), in pieces of `element` cells.

        Pieces are shorter where walls meet and end where they cross and where shadows of points
        and parallel light end. What lies outside the grid or on an earlier segment is left out.
        """
        geometry, bounced = self._read(scene)
        lights = len(geometry.emitters)
        elements = cut_walls(geometry, self.values["element"], geometry.surfaces >= lights)
        flux = arriving_flux(geometry, elements.segments, bounced)
        mean = flux / (elements.lengths[:, None] * scene.grid.spacing)
        ends = scene.grid.to_world(elements.segments.reshape(-1, 2, 2))
        values = _per_colour(scene, mean.T)
        return SurfaceLight(elements.owners - lights, ends[:, 0], ends[:, 1], values)

    def irradiance_at(self, scene: Scene, points: ArrayLike, normals: ArrayLike) -> Array:
        """Irradiance ([colours,] K) [W/m] at world points (K, 2) of surfaces with unit normals.

        Points may lie on walls: the normal (K, 2) says on which side.
        """
        geometry, bounced = self._read(scene)
        places = checked_points("points", points, (-1, 2))
        unit = checked_directions(normals, "normals")
        if len(unit) != len(places):
            raise bad_input("normals", normals, f"must be as many as points: {len(places)}")
        cells = np.array([geometry.in_cells(place) for place in places]).reshape(-1, 2)
        values = irradiance_at(geometry, cells, unit, *all_emitters(geometry, bounced))
        return _per_colour(scene, values.T / scene.grid.spacing)

    def energy(self, scene: Scene) -> Ledger:
        """Flux [W] emitted, left over the border and absorbed by segments, () or (colours,).

        By crossed strings over whole walls, apart from cells and bands, so that the closure of
        these books checks the geometry. Reflected light closes them at any `element`.
        """
        geometry, bounced = self._read(scene)
        return balance(geometry, scene.colours > 0, bounced)

    def absorbed(self, scene: Scene) -> Array:
        """Flux ([colours,] S) [W] that both sides of each of scene.segments() absorb."""
        geometry, bounced = self._read(scene)
        flux = absorbed_flux(geometry, bounced)[len(geometry.emitters) :]
        return flux.T if scene.colours else flux[:, 0]

    def _field(self, scene: Scene, bands: int, element: float) -> Field:
        geometry, bounced = self._read(scene, element)
        basis = CircularHarmonics(bands)
        colours = geometry.radiance.shape[1]
        # Outlines of cells, moments, and their copy with the colours and coefficients first.
        needed = scene.grid.cell_count * (16 + 2 * colours * basis.size) * 8
        require_memory(needed, "bands", bands)
        outlines = geometry.cell_outlines()
        moments = collect_all(geometry, outlines, basis.bands, bounced)
        moments /= np.where(basis.degrees > 0, np.sqrt(np.pi), np.sqrt(2 * np.pi))
        values = moments.reshape(*scene.grid.shape, colours, basis.size).transpose(2, 3, 0, 1)
        return Field(scene.grid, basis, _per_colour(scene, np.ascontiguousarray(values)))

    def _read(self, scene: Scene, element: float = 0.0) -> tuple[Geometry, Bounced | None]:
        """A scene's arrays and, if anything reflects, what its walls send back."""
        self.require_dimension(scene.grid.dimension)
        geometry = read_geometry(scene)
        if not self.values["bounces"]:
            geometry = replace(geometry, albedo=np.zeros_like(geometry.albedo))
        size = element or self.values["element"]
        return geometry, bounce(geometry, size) if geometry.reflects else None


def _per_colour(scene: Scene, values: Array) -> Array:
    """Without the leading axis (max(1, colours)) if the scene is grey."""
    return values if scene.colours else values[0]
