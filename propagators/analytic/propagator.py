"""The exact answer for flat scenes, as a propagator."""

from __future__ import annotations

import warnings
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import SchemeWarning, bad_input
from flatland.field import Field
from flatland.harmonics import CircularHarmonics
from flatland.ledger import Ledger
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.analytic.arcs import Arc, visible_arcs
from propagators.analytic.balance import absorbed_flux, balance
from propagators.analytic.beams import beam_intensity, ray_intensity
from propagators.analytic.geometry import Geometry, read_geometry
from propagators.analytic.points import collect_point_light
from propagators.analytic.targets import collect_light
from propagators.base import Propagator

Array = NDArray[np.float64]


class Analytic(Propagator):
    """The reference in 2D: what leaves each cell, in closed form in angle and in space.

    I_ref(ω) = ∫_{∂cell, n·ω>0} L(x, ω) (n·ω) dA (numerics §1). Between the places where edges of
    segments line up, what a face sees of an emitter is bounded by two edges, and its harmonics
    are a sum over four strings (`strings`; Hottel 1954 for band 0). There is nothing to refine:
    the error is rounding, about 1e-13 of the largest coefficient, at any number of bands.

    Lights are Lambertian segments, opaque from both sides, and points; occluders are black and
    opaque. Light that arrives at a face on which a segment lies counts as outflow of the cell it
    comes from; light that starts there is no outflow of the cell behind.

    What it gets wrong: nothing bounces (an albedo is ignored, with a SchemeWarning). Geometry is
    exact to 1e-10 cells: nearer things touch. A light shorter than 1e-5 cells therefore loses
    digits in its penumbrae (1e-9 of its flux at 1e-8 cells).
    """

    name = "analytic"
    summary = "the exact answer in 2D: visible arcs and crossed strings"
    dimensions: ClassVar = (2,)

    def solve(self, scene: Scene, bands: int, tolerance: float = 1e-8) -> Field:
        """The exact field, coefficients ([colours,] size, nx, ny).

        tolerance is there for the common signature: the closed form meets any that float64 can.
        """
        geometry = self._read(scene)
        basis = CircularHarmonics(bands)
        colours = geometry.radiance.shape[1]
        # Outlines of cells, moments, and their copy with the colours and coefficients first.
        needed = scene.grid.cell_count * (16 + 2 * colours * basis.size) * 8
        require_memory(needed, "bands", bands)
        outlines = geometry.cell_outlines()
        moments = collect_light(
            outlines, geometry.emitters, geometry.radiance, geometry.walls, basis.bands
        )
        if len(geometry.positions):
            points = geometry.positions, geometry.series, geometry.lobes, geometry.spectra
            moments += collect_point_light(outlines, *points, geometry.walls, basis.bands)
        moments /= np.where(basis.degrees > 0, np.sqrt(np.pi), np.sqrt(2 * np.pi))
        values = moments.reshape(*scene.grid.shape, colours, basis.size).transpose(2, 3, 0, 1)
        return Field(scene.grid, basis, _per_colour(scene, np.ascontiguousarray(values)))

    def intensity(self, scene: Scene, directions: ArrayLike) -> Array:
        """I_ref ([colours,] K, nx, ny) [W/rad] at unit directions (K, 2), not band-limited.

        A point source counts, in full, in the cells whose border its ray crosses.
        """
        geometry = self._read(scene)
        unit = _checked_directions(directions)
        shape = scene.grid.shape[0], scene.grid.shape[1]
        values = beam_intensity(shape, unit, geometry.emitters, geometry.radiance, geometry.walls)
        if len(geometry.positions):
            strength = geometry.point_intensity(unit)
            values += ray_intensity(shape, unit, geometry.positions, strength, geometry.walls)
        return _per_colour(scene, np.ascontiguousarray(np.moveaxis(values, 1, 0)))

    def arcs(self, scene: Scene, point: ArrayLike) -> list[Arc]:
        """The light of segment lights at a world point (2,), as arcs of directions of travel."""
        geometry = self._read(scene)
        place = np.asarray(point, float)
        if place.shape != (2,) or not np.all(np.isfinite(place)):
            raise bad_input("point", point, "must be 2 finite numbers")
        x, y = geometry.in_cells(place)
        radiance = geometry.radiance / scene.grid.spacing
        found = visible_arcs(x, y, geometry.emitters, geometry.walls)
        return [
            Arc(
                float(start),
                float(stop),
                radiance[int(e)] if scene.colours else float(radiance[int(e), 0]),
                int(geometry.emitter_sources[int(e)]),
            )
            for start, stop, e in found
        ]

    def energy(self, scene: Scene) -> Ledger:
        """Flux [W] emitted, left over the border and absorbed by segments, () or (colours,).

        By crossed strings over whole walls, apart from cells and bands, so that the closure of
        these books checks the geometry.
        """
        return balance(self._read(scene), coloured=scene.colours > 0)

    def absorbed(self, scene: Scene) -> Array:
        """Flux ([colours,] S) [W] that arrives on both sides of each of scene.segments()."""
        geometry = self._read(scene)
        flux = absorbed_flux(geometry)[len(geometry.emitters) :]
        return flux.T if scene.colours else flux[:, 0]

    def _read(self, scene: Scene) -> Geometry:
        self.require_dimension(scene.grid.dimension)
        if any(np.any(np.asarray(wall.albedo) > 0) for wall in scene.segments()):
            message = "the analytic reference ignores albedo: its occluders absorb all light"
            warnings.warn(message, SchemeWarning, stacklevel=3)
        return read_geometry(scene)


def _per_colour(scene: Scene, values: Array) -> Array:
    """Without the leading axis (max(1, colours)) if the scene is grey."""
    return values if scene.colours else values[0]


def _checked_directions(directions: ArrayLike) -> Array:
    unit = np.atleast_2d(np.asarray(directions, float))
    lengths = np.linalg.norm(unit, axis=-1)
    if unit.ndim != 2 or unit.shape[1] != 2 or not np.all(np.abs(lengths - 1) < 1e-6):
        raise bad_input("directions", directions, "must be unit vectors of shape (K, 2)")
    return np.ascontiguousarray(unit / lengths[:, None])
