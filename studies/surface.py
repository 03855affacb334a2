"""How well a field lights the surfaces of its scene, against the exact irradiance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.facets import cut_by_cells, facet_table
from flatland.field import Field
from flatland.grid import Grid
from flatland.scene import Scene
from flatland.surface_light import METHODS, Method, irradiance
from propagators import create

Array = NDArray[np.float64]

#: How far from a surface the field is looked up, in cells: on it as in the paper, or before it.
OFFSETS = (0.0, 0.5)
#: Longest piece of a wall with one sample, in cells.
LONGEST = 0.5


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Pieces of both sides of all occluders, where these face the grid.

    points: middles (M, dimension) [m]. normals: unit vectors (M, dimension) to the lit side. sizes:
    lengths (M,) [m], areas [m²] in 3D. exact: irradiance ([colours,] M) [W/m, W/m² in 3D]: in 2D
    the mean over each piece, in 3D at its middle.
    """

    points: Array
    normals: Array
    sizes: Array
    exact: Array


@dataclass(frozen=True)
class SurfaceError:
    """A row of the table. error: relative L2. ratio: flux found over exact flux, or NaN."""

    method: Method
    offset: float
    damping: bool
    error: float
    ratio: float


def surface_samples(scene: Scene) -> SurfaceSamples:
    """Samples of a scene with the exact irradiance of `analytic`, pieces of at most h/2.

    What it gets wrong: in 3D the exact irradiance at a middle stands for the whole piece, an error
    of the second order in its size, of the first where shadows end. Walls that lie on one another
    count twice there. Raises InputError for scenes without occluders and for those that
    `analytic` refuses.
    """
    if not scene.walls():
        raise bad_input("--surfaces", scene.title, "the scene has no occluders to be lit")
    return _samples_of_segments(scene) if scene.grid.dimension == 2 else _samples_of_facets(scene)


def _samples_of_segments(scene: Scene) -> SurfaceSamples:
    light = create("analytic", element=LONGEST).irradiance(scene)  # type: ignore[attr-defined]
    along = light.stops - light.starts
    lengths = np.hypot(*along.T)
    normals = np.stack([-along[:, 1], along[:, 0]], axis=-1) / lengths[:, None]
    points = (light.starts + light.stops) / 2
    # A wall on the border has no field on its outer side.
    inner = scene.grid.contains(points + 1e-3 * scene.grid.spacing * normals)
    exact = light.irradiance[..., inner]
    return SurfaceSamples(points[inner], normals[inner], lengths[inner], exact)


def _samples_of_facets(scene: Scene) -> SurfaceSamples:
    """Facets are cut by cells of size h/2; on the border the side that faces out is left out."""
    grid = scene.grid
    parts = round(1 / LONGEST)
    fine = Grid(tuple(parts * n for n in grid.shape), grid.spacing / parts, grid.origin)
    table = facet_table(fine, scene.facets())
    sides = [(each, cut_by_cells(each, fine.shape)) for each in (table, table.turned())]
    points = fine.to_world(np.concatenate([pieces.middles for _, pieces in sides]))
    normals = np.concatenate([each.normals[pieces.facets] for each, pieces in sides])
    areas = np.concatenate([pieces.areas for _, pieces in sides]) * fine.spacing**2
    exact = create("analytic").irradiance_at(scene, points, normals)  # type: ignore[attr-defined]
    return SurfaceSamples(points, normals, areas, exact)


def surface_irradiance_error(
    field: Field,
    samples: SurfaceSamples,
    method: Method = "distance",
    damping: bool = False,
    offset: float = 0.0,
) -> SurfaceError:
    """√(Σ s (E - E_ref)² / Σ s E_ref²) over pieces of size s and colours, 1 for a black field.

    E is taken at the middle of a piece, E_ref is the samples' exact one. Both sides count, so that
    light leaked to a dark one is an error.
    """
    found = irradiance(field, samples.points, samples.normals, method, damping, offset)
    size = float(np.sqrt(np.sum(samples.sizes * samples.exact**2)))
    wrong = float(np.sqrt(np.sum(samples.sizes * (found - samples.exact) ** 2)))
    flux, exact = (float(np.sum(samples.sizes * each)) for each in (found, samples.exact))
    error = wrong / size if size > 0 else (0.0 if wrong == 0 else float("inf"))
    return SurfaceError(method, offset, damping, error, flux / exact if exact > 0 else float("nan"))


def surface_errors(field: Field, samples: SurfaceSamples) -> list[SurfaceError]:
    """Every way to light surfaces: methods, offsets, without and with damping."""
    return [
        surface_irradiance_error(field, samples, method, damping, offset)
        for method in METHODS
        for offset in OFFSETS
        for damping in (False, True)
    ]
