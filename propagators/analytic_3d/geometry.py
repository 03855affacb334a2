"""A 3D scene as plain arrays in cell units: the only reader of scenes in this package."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.facets import vector_area
from flatland.grid import Grid
from flatland.scene import Scene
from flatland.sources import Facet, ParallelSource, PointSource, PolygonSource, Source
from propagators.analytic.geometry import SNAP
from propagators.analytic_3d.plates import TOUCH, Plates, clip_to_box, convex_parts, make_plates

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Kind = TypeVar("Kind", bound=Source)


@dataclass(frozen=True, eq=False)
class Geometry:
    """What sends and what stops light; lengths in cells, fluxes in watts.

    lights: convex plates of the area lights, each lights its front. radiance: (L, C) flux per
    solid angle and projected area of a cell's face, C = max(1, colours).
    points: point sources at positions (Q, 3). beams: parallel sources, with irradiances (D, C) on
    the face of a cell.
    polygons: outlines (V, 3) of the surfaces: area lights, then scene.facets(). light_count: how
    many of them are lights. albedo: (surfaces, C); lights are black.
    walls: convex plates of everything opaque, cut at the grid's border; surfaces: (P,) which
    surface each is of. gates: (P,), which are lights in the grid's border: parallel light comes
    in through them, so that a sun and a sky can shine together.
    """

    grid: Grid
    lights: Plates
    radiance: Array
    points: list[PointSource]
    positions: Array
    beams: list[ParallelSource]
    irradiances: Array
    polygons: list[Array]
    light_count: int
    albedo: Array
    walls: Plates
    surfaces: Indices
    gates: NDArray[np.bool_]

    @property
    def colours(self) -> int:
        """Columns of every spectrum, at least 1."""
        return self.albedo.shape[1]

    @property
    def reflects(self) -> bool:
        """Whether any wall in the grid sends light back."""
        return bool(np.any(self.albedo[self.surfaces] > 0))

    @property
    def shading(self) -> Plates:
        """The walls that stop parallel light."""
        return self.walls if not self.gates.any() else _chosen(self.walls, ~self.gates)

    def black(self) -> Geometry:
        """The same scene with walls that send nothing back."""
        return replace(self, albedo=np.zeros_like(self.albedo))


def read_geometry(scene: Scene) -> Geometry:
    """The arrays of a scene. Raises InputError for an area light without area."""
    grid, colours = scene.grid, max(1, scene.colours)
    sources = scene.sources("lamp")
    lights, facets = _of(sources, PolygonSource), scene.facets()
    outlines = [light.vertices for light in lights] + [facet.vertices for facet in facets]
    polygons = [snapped(grid.to_cells(outline)) for outline in outlines]
    areas = [float(np.linalg.norm(vector_area(polygon))) for polygon in polygons]
    if lights and min(areas[: len(lights)]) == 0:
        broken = lights[int(np.argmin(areas[: len(lights)]))]
        raise bad_input("vertices", broken.vertices, "must span an area: a light needs one")
    emitting = [convex_parts(polygon) for polygon in polygons[: len(lights)]]
    spectra = [light.spectrum / (np.pi * area) for light, area in zip(lights, areas)]
    walls, surfaces = _inside(grid, polygons, areas)
    points, beams = _of(sources, PointSource), _of(sources, ParallelSource)
    return Geometry(
        grid,
        make_plates(part for parts in emitting for part in parts),
        np.array([s for s, parts in zip(spectra, emitting) for _ in parts]).reshape(-1, colours),
        points,
        snapped(grid.to_cells(np.array([p.position for p in points]).reshape(-1, 3))),
        beams,
        grid.spacing**2 * np.array([b.spectrum for b in beams], float).reshape(-1, colours),
        polygons,
        len(lights),
        _albedo(len(lights), facets, colours),
        walls,
        surfaces,
        _gates(grid, walls, surfaces < len(lights)),
    )


def snapped(cells: Array) -> Array:
    """Coordinates, put onto the grid planes that they nearly lie on."""
    nearest = np.rint(cells)
    return np.asarray(np.where(np.abs(cells - nearest) < SNAP, nearest, cells))


def _of(sources: Sequence[Source], kind: type[Kind]) -> list[Kind]:
    return [source for source in sources if isinstance(source, kind)]


def _inside(grid: Grid, polygons: list[Array], areas: list[float]) -> tuple[Plates, Indices]:
    """Convex plates of the polygons in the grid, and which polygon each is of."""
    parts, owners = [], []
    for place, (polygon, area) in enumerate(zip(polygons, areas)):
        for part in convex_parts(polygon) if area > 0 else []:
            cut = clip_to_box(part, grid.shape)
            if len(cut) > 2 and np.linalg.norm(vector_area(cut)) > TOUCH**2:
                parts.append(cut)
                owners.append(place)
    return make_plates(parts), np.array(owners, np.int64)


def _albedo(light_count: int, facets: list[Facet], colours: int) -> Array:
    albedo = np.zeros((light_count + len(facets), colours))
    for row, facet in zip(albedo[light_count:], facets):
        row[:] = facet.albedo
    return albedo


def _gates(grid: Grid, walls: Plates, lights: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the walls are lights in a side of the grid."""
    flat = walls.low == walls.high
    on_side = flat & ((walls.low == 0) | (walls.low == np.array(grid.shape)))
    return np.asarray(lights & on_side.any(axis=1))


def _chosen(plates: Plates, chosen: NDArray[np.bool_]) -> Plates:
    counts = np.diff(plates.first)
    first = np.concatenate([[0], np.cumsum(counts[chosen])]).astype(np.int64)
    vertices = plates.vertices[np.repeat(chosen, counts)]
    return Plates(vertices, first, *(each[chosen] for each in plates[2:]))
