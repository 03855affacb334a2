"""What exact blocking sends back: the lobe of the wall that stopped each link."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.blocking.covers import Covers
from flatland.blocking.exact import Beams, beams, forward_directions
from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.kernels.reflection import Reflection
from flatland.sources import Wall

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

#: A wall whose normal is closer than this to a right angle with the light is seen edge-on.
EDGE_ON = 1e-9


def exact_reflection(
    grid: Grid,
    walls: Sequence[Wall],
    offsets: ArrayLike,
    basis: AngularBasis,
    transmittance: Array,
) -> list[Reflection]:
    """What walls send back of what they stop, one reflection per colour of their albedo.

    Of the flux that leaves cell x along d, 1 − τ(x, d) is stopped. Each wall in that beam has
    stopped a part of it that is proportional to the width (in 3D, the area) of the beam it covers,
    and sends albedo times that back into x as a Lambertian lobe along its normal, on the side that
    faces the light. transmittance: (K, *shape), as `exact_transmittance` gives it.

    What it gets wrong. Where one wall in a beam stands behind another, both reflect by what
    they cover, not by what reaches them. The place on the wall is lost: light comes back from the
    centre of x, up to a cell in front of the wall, so that a corridor narrower than a cell is
    one cell wide. Where few bands ring, negative flux is stopped and sent back like any other.
    The local term may then make a scheme unstable that is stable without walls: found with
    lpv-2009 (spectral radius 1.02 among loose white walls, 2 bands), not with LPV, DOM4 and DOM8.
    """
    steps = np.asarray(offsets, np.int64)
    albedo = np.array([wall.albedo for wall in walls], float)
    number = np.full(grid.shape, -1)
    touched = np.argwhere((transmittance < 1).any(axis=0))
    number[tuple(touched.T)] = np.arange(len(touched))
    lobes = np.zeros((albedo.shape[1], len(touched), len(steps), basis.size))
    for d, stopped in _stopped(beams(grid, walls), grid.shape, steps, transmittance):
        back = basis.lambertian(_facing(stopped.normals, steps[d]), basis.flux_weight)
        rows = number[tuple(stopped.cells.T)]
        for result, share in zip(lobes, (stopped.shares[:, None] * albedo[stopped.walls]).T):
            np.add.at(result[:, d], rows, share[:, None] * back)
    return [without_idle_cells(touched, part) for part in lobes]


def without_idle_cells(cells: Cells, lobes: Array) -> Reflection:
    """A reflection of those cells only that get anything back."""
    busy = lobes.any(axis=(1, 2))
    return Reflection(np.ascontiguousarray(cells[busy]), np.ascontiguousarray(lobes[busy]))


def _stopped(
    cut: Beams, shape: tuple[int, ...], steps: Cells, transmittance: Array
) -> Iterator[tuple[int, Covers]]:
    """Per offset: its number, and the share of a link's flux that each wall stops."""
    for direction in forward_directions(steps):
        covers = cut.covers(direction)
        for d, step in enumerate(steps):
            if np.array_equal(step, direction):
                yield d, _shared_out(covers, shape, transmittance[d])
            elif np.array_equal(step, -direction):
                there = covers._replace(cells=covers.cells + direction)
                yield d, _shared_out(there, shape, transmittance[d])


def _shared_out(covers: Covers, shape: tuple[int, ...], open_share: Array) -> Covers:
    """What is stopped of each link from a cell of the grid, among the walls in its beam."""
    covers = covers.within(shape)
    link = np.ravel_multi_index(tuple(covers.cells.T), shape).astype(np.int64)
    count = int(np.prod(shape))
    # Shut by its centre ray alone, by walls that cover nothing: each counts the same.
    bare = np.bincount(link, covers.shares, count)[link] == 0
    widths = np.where(bare, 1.0, covers.shares)
    total = np.bincount(link, widths, count)[link]
    shares = widths / total * (1 - open_share[tuple(covers.cells.T)])
    return covers._replace(shares=shares)


def _facing(normals: Array, step: Cells) -> Array:
    """Normals (M, dimension) against the light; straight back where a wall is seen edge-on."""
    direction = step / np.linalg.norm(step)
    slope = normals @ direction
    facing = normals * -np.sign(slope)[:, None]
    return np.where(np.abs(slope)[:, None] < EDGE_ON, -direction, facing)
