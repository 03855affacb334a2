"""What exact blocking sends back: the lobe of the wall that stopped each link."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.blocking.exact import clipped_walls, forward, records
from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.kernels.reflection import Reflection
from flatland.sources import Segment

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

#: A wall whose normal is closer than this to a right angle with the light is seen edge-on.
EDGE_ON = 1e-9


def exact_reflection(
    grid: Grid,
    segments: Sequence[Segment],
    offsets: ArrayLike,
    basis: AngularBasis,
    transmittance: Array,
) -> list[Reflection]:
    """What walls send back of what they stop, one reflection per colour of their albedo.

    Of the flux that leaves cell x along d, 1 − τ(x, d) is stopped. Each wall in that beam has
    stopped a part of it that is proportional to the width of the beam it covers, and sends
    albedo times that back into x as a Lambertian lobe along its normal, on the side that faces
    the light. transmittance: (K, *shape), as `exact_transmittance` gives it.

    What it gets wrong. Where one wall in a beam stands behind another, both reflect by their
    width, not by what reaches them. The place on the wall is lost: light comes back from the
    centre of x, up to a cell in front of the wall, so that a corridor narrower than a cell is
    one cell wide. Where few bands ring, negative flux is stopped and sent back like any other.
    The local term may then make a scheme unstable that is stable without walls: found with
    lpv-2009 (spectral radius 1.02 among loose white walls, 2 bands), not with LPV, DOM4 and DOM8.
    """
    steps = np.asarray(offsets, np.int64)
    walls, origin = clipped_walls(grid, segments)
    along = np.diff(walls, axis=1)[:, 0]
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
    # A wall without length stops nothing.
    normals /= np.maximum(np.hypot(*normals.T), np.finfo(float).tiny)[:, None]
    albedo = np.array([segments[i].albedo for i in origin], float)
    number = np.full(grid.shape, -1)
    touched = np.argwhere((transmittance < 1).any(axis=0))
    number[tuple(touched.T)] = np.arange(len(touched))
    lobes = np.zeros((albedo.shape[1], len(touched), len(steps), basis.size))
    for d, cells, wall, shares in _stopped(grid.shape, walls, steps, transmittance):
        back = basis.lambertian(_facing(normals[wall], steps[d]), basis.flux_weight)
        for result, share in zip(lobes, (shares[:, None] * albedo[wall]).T):
            np.add.at(result[:, d], number[tuple(cells.T)], share[:, None] * back)
    return [without_idle_cells(touched, part) for part in lobes]


def without_idle_cells(cells: Cells, lobes: Array) -> Reflection:
    """A reflection of those cells only that get anything back."""
    busy = lobes.any(axis=(1, 2))
    return Reflection(np.ascontiguousarray(cells[busy]), np.ascontiguousarray(lobes[busy]))


def _stopped(
    shape: tuple[int, ...], walls: Array, steps: Cells, transmittance: Array
) -> Iterator[tuple[int, Cells, Cells, Array]]:
    """Per offset: its number, cells (M, 2), walls (M,) and the share that each stops (M,)."""
    for d, step in enumerate(steps):
        direction = np.array(forward(step))
        cells, spans, _, wall = records(walls, direction)
        if not np.array_equal(step, direction):
            cells = cells + direction
        inside = np.all((cells >= 0) & (cells < shape), axis=1)
        cells, wall, widths = cells[inside], wall[inside], np.diff(spans[inside])[:, 0]
        link = np.ravel_multi_index(tuple(cells.T), shape).astype(np.int64)
        # Shut by its centre ray alone, by walls that cover nothing: each counts the same.
        bare = np.bincount(link, widths, int(np.prod(shape)))[link] == 0
        widths = np.where(bare, 1.0, widths)
        total = np.bincount(link, widths, int(np.prod(shape)))[link]
        yield d, cells, wall, widths / total * (1 - transmittance[(d, *cells.T)])


def _facing(normals: Array, step: Cells) -> Array:
    """Normals (M, 2) turned against the light; straight back where a wall is seen edge-on."""
    direction = step / np.hypot(*step)
    slope = normals @ direction
    facing = normals * -np.sign(slope)[:, None]
    return np.where(np.abs(slope)[:, None] < EDGE_ON, -direction, facing)
