"""What the analytic reference answers about one 3D scene."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import ConvergenceError
from flatland.field import Field
from flatland.harmonics import SphericalHarmonics
from flatland.ledger import Ledger
from flatland.memory import require_memory
from flatland.scene import Scene
from propagators.analytic.checks import checked_directions, checked_surfaces, per_colour
from propagators.analytic_3d.balance import absorbed_flux, arrivals, balance
from propagators.analytic_3d.cells import cell_intensity, cell_light
from propagators.analytic_3d.directions import even_beams
from propagators.analytic_3d.elements import Elements, cut_walls
from propagators.analytic_3d.faces import cut_faces
from propagators.analytic_3d.geometry import read_geometry, snapped
from propagators.analytic_3d.irradiance import FacetLight, irradiance_at, point_intensity
from propagators.analytic_3d.lighting import direct_light
from propagators.analytic_3d.projection import projected_intensity
from propagators.analytic_3d.radiosity import Bounced, bounce, mean_of
from propagators.analytic_3d.rays import ray_intensity

Array = NDArray[np.float64]
Report = Callable[[float], object]

#: Directions of the first try, and the most that are ever used: 16³ cells then take minutes.
_FIRST, _MOST = 256, 2**18
#: Share of the tolerance that direct light, which converges fast, may use up.
_DIRECT = 0.5
#: Radiosity of single elements may be off by this many tolerances: sums over them are not.
_LOOSE = 4.0
#: The estimate scatters: it has to be below the tolerance by this much.
_MARGIN = 0.8
#: Cells. Longest piece of a black wall, whose light need not be known in detail.
_COARSE = 2.0
#: Shares of the work that are done after direct light, and after the first try of the rest.
_AFTER_DIRECT, _AFTER_TRY = 0.3, 0.4


class VolumeAnswer:
    """See `Analytic`. element: cells. tolerance: relative L2. progress: gets the share done."""

    def __init__(
        self,
        scene: Scene,
        element: float,
        bounces: bool,
        tolerance: float,
        progress: Report | None = None,
    ) -> None:
        self.scene, self.element, self.tolerance = scene, element, tolerance
        self._report: Report = progress or (lambda share: None)
        geometry = read_geometry(scene)
        self.geometry = geometry if bounces else geometry.black()

    def field(self, bands: int) -> Field:
        """The field of all light, direct and reflected."""
        grid, basis = self.scene.grid, SphericalHarmonics(bands)
        colours, cells = self.geometry.colours, grid.cell_count
        # Six faces a cell as panels, with their values; the result and its copy.
        needed = cells * 8 * (6 * (32 + colours * basis.size) + 3 * colours * basis.size)
        require_memory(needed, "bands", bands)
        faces = cut_faces(grid, self.geometry.walls)
        values = direct_light(self.geometry, faces, cells, bands, _DIRECT * self.tolerance)
        if self.geometry.reflects:
            self._report(_AFTER_DIRECT)
            values += self._reflected(values, bands, self.element)
        self._report(1.0)
        ordered = values.transpose(1, 2, 0).reshape(colours, basis.size, *grid.shape)
        return Field(grid, basis, per_colour(self.scene, np.ascontiguousarray(ordered)))

    def bounce_error(self, bands: int) -> float:
        """Change of the field when elements are halved, lines being the same."""
        if not self.geometry.reflects:
            return 0.0
        coarse, fine = (self._trial(bands, size) for size in (self.element, self.element / 2))
        faces = cut_faces(self.scene.grid, self.geometry.walls)
        cells = self.scene.grid.cell_count
        direct = direct_light(self.geometry, faces, cells, bands, _DIRECT * self.tolerance)
        norm = float(np.linalg.norm(direct + fine))
        return float(np.linalg.norm(coarse - fine)) / norm if norm else 0.0

    def intensity(self, directions: ArrayLike) -> Array:
        """Intensities ([colours,] K, nx, ny, nz)."""
        geometry, shape = self.geometry, self.scene.grid.shape
        unit = checked_directions(directions, dimension=3)
        needed = 16 * len(unit) * geometry.colours * self.scene.grid.cell_count
        require_memory(needed, "directions", unit.shape)
        values = projected_intensity(
            shape, unit, geometry.lights, geometry.radiance, geometry.walls
        )
        if geometry.points:
            strength = np.stack(
                [point_intensity(p, unit)[:, None] * p.spectrum for p in geometry.points], axis=1
            )
            values += ray_intensity(shape, unit, geometry.positions, strength, geometry.walls)
        if geometry.reflects:
            values += cell_intensity(self._bounced(self._elements()), shape, unit).reshape(
                values.shape
            )
        return per_colour(self.scene, np.ascontiguousarray(np.moveaxis(values, 1, 0)))

    def irradiance(self) -> FacetLight:
        """Means over elements of all facets, both sides."""
        geometry, grid = self.geometry, self.scene.grid
        elements = cut_walls(geometry, self.element, self.element)
        incoming = self._incoming(elements)
        sides = np.flatnonzero(elements.side_owners >= geometry.light_count)
        normals = (
            np.repeat(elements.normals, 2, axis=0)
            * np.tile([1.0, -1.0], len(elements.areas))[:, None]
        )
        return FacetLight(
            elements.side_owners[sides] - geometry.light_count,
            grid.to_world(np.repeat(elements.centres, 2, axis=0))[sides],
            normals[sides],
            elements.side_areas[sides] * grid.spacing**2,
            per_colour(self.scene, incoming[sides].T / grid.spacing**2),
        )

    def irradiance_at(self, points: ArrayLike, normals: ArrayLike) -> Array:
        """Irradiances ([colours,] K)."""
        places, unit = checked_surfaces(points, normals, 3)
        cells = snapped(self.scene.grid.to_cells(places))
        bounced = self._bounced(self._elements()) if self.geometry.reflects else None
        values = irradiance_at(self.geometry, cells, unit, bounced)
        return per_colour(self.scene, values.T / self.scene.grid.spacing**2)

    def energy(self) -> Ledger:
        """The books."""
        geometry, elements = self.geometry, self._elements()
        bounced = self._bounced(elements) if geometry.reflects else None
        incoming = bounced.incoming if bounced else self._incoming(elements)
        books = balance(geometry, elements, incoming, bounced, self.tolerance)
        if self.scene.colours:
            return books
        return Ledger(books.emitted[0], books.left[0], books.absorbed[0])

    def absorbed(self) -> Array:
        """Flux ([colours,] S) that facets keep."""
        elements = self._elements()
        flux = absorbed_flux(self.geometry, elements, self._incoming(elements))
        return per_colour(self.scene, flux[self.geometry.light_count :].T)

    def _elements(self) -> Elements:
        return cut_walls(self.geometry, self.element, max(self.element, _COARSE))

    def _incoming(self, elements: Elements) -> Array:
        if self.geometry.reflects:
            return self._bounced(elements).incoming
        return arrivals(self.geometry, elements, self.tolerance)

    def _bounced(self, elements: Elements) -> Bounced:
        """Radiosity by as many lines as it takes."""
        given = arrivals(self.geometry, elements, _DIRECT * self.tolerance)
        root = np.sqrt(elements.side_areas)[:, None]
        count = _FIRST
        while True:
            pair = [self._bounce(elements, given, count, seed) for seed in (1, 2)]
            found = mean_of(*pair)
            error = float(np.linalg.norm(root * (pair[0].radiosity - found.radiosity)))
            wanted = _LOOSE * self.tolerance * float(np.linalg.norm(root * found.radiosity))
            if error <= wanted:
                return found
            count = self._more(count, error, wanted)

    def _reflected(self, direct: Array, bands: int, size: float) -> Array:
        """Light of walls through cells (cells, C, size), by as many lines as it takes.

        The difference of two independent answers is the error estimate of their mean.
        """
        elements = cut_walls(self.geometry, size, max(size, _COARSE))
        given = arrivals(self.geometry, elements, _DIRECT * self.tolerance)
        count, start, stop = _FIRST, _AFTER_DIRECT, _AFTER_TRY
        while True:
            middle = (start + stop) / 2
            first = self._carry(elements, given, bands, count, 1, (start, middle))
            second = self._carry(elements, given, bands, count, 2, (middle, stop))
            found, error = (first + second) / 2, float(np.linalg.norm(first - second)) / 2
            wanted = _MARGIN * self.tolerance * float(np.linalg.norm(direct + found))
            if error <= wanted:
                return found
            count = self._more(count, error, wanted)
            start, stop = stop, (stop + 9.0) / 10

    def _trial(self, bands: int, size: float) -> Array:
        """The same with few lines, always the same ones."""
        elements = cut_walls(self.geometry, size, max(size, _COARSE))
        given = arrivals(self.geometry, elements, _DIRECT * self.tolerance)
        return self._carry(elements, given, bands, 4 * _FIRST, 1, (0.0, 1.0))

    def _carry(
        self,
        elements: Elements,
        given: Array,
        bands: int,
        count: int,
        seed: int,
        shares: tuple[float, float],
    ) -> Array:
        bounced = self._bounce(elements, given, count // 2, seed)
        start, stop = shares
        beams, shape = even_beams(count, seed), self.scene.grid.shape
        return cell_light(
            bounced, shape, bands, beams, lambda done: self._report(start + done * (stop - start))
        )

    def _bounce(self, elements: Elements, given: Array, count: int, seed: int) -> Bounced:
        return bounce(self.geometry, elements, given, even_beams(count, -seed % 2**32))

    def _more(self, count: int, error: float, wanted: float) -> int:
        """Directions that should do: errors fall with the square root of their number."""
        needed = int(np.ceil(count * max(2.0, 1.2 * (error / wanted) ** 2)))
        if needed <= _MOST:
            return needed
        reachable = self.tolerance * error / wanted * (count / _MOST) ** 0.5
        raise ConvergenceError(
            f"tolerance = {self.tolerance:g}: light between walls would take {needed} directions, "
            f"more than {_MOST}; with those, about {1.2 * reachable:.1g} can be reached"
        )
