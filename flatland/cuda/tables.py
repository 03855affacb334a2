"""Numbers that kernels read beside fields: τ of links, border cells, lobes of walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
from flatland.kernels.orbits import significant
from flatland.stencil import Stencil

Array = NDArray[np.float64]


def wall_shares(
    offsets: NDArray[np.int64], layout: Layout, transmittance: Array
) -> tuple[NDArray[np.int32], NDArray[np.floating]]:
    """τ (K, near) of what arrives in the cells that walls are near, and their numbers.

    transmittance: (K, *shape), of what leaves. Numbers (*shape,), flat: which column a cell has,
    -1 where all that arrives is open. Most cells of most scenes are such, and need no τ.
    """
    arriving = np.ones((len(offsets), *layout.shape), layout.dtype)
    for kept, share, offset in zip(arriving, transmittance, offsets):
        sides = list(zip(map(int, offset), layout.shape))
        stay = tuple(slice(max(0, -o), n - max(0, o)) for o, n in sides)
        arrive = tuple(slice(max(0, o), n - max(0, -o)) for o, n in sides)
        kept[arrive] = share[stay]
    flat = arriving.reshape(len(offsets), -1)
    near = np.flatnonzero((flat != 1).any(axis=0))
    numbers = np.full(flat.shape[1], -1, np.int32)
    numbers[near] = np.arange(near.size)
    return numbers, flat[:, near]


def lobes_table(lobes: Array) -> tuple[Array, int]:
    """Lobes (M, K, size) as the kernels read them, (lit, K, M), and `lit`.

    Components behind the last one that anything comes back in are left out.
    """
    used = np.flatnonzero(lobes.any(axis=(0, 1)))
    lit = int(used[-1]) + 1 if used.size else 1
    return np.ascontiguousarray(np.moveaxis(lobes[:, :, :lit], 0, 2).swapaxes(0, 1)), lit


def leaving_shares(
    stencil: Stencil, shape: tuple[int, ...], cells: NDArray[np.int64], tau: Array | None
) -> Array:
    """Open share (M, K) of the links of cells (M, dimension) that lead outside; 0 for others."""
    shares = np.zeros((len(cells), len(stencil.offsets)))
    for d, offset in enumerate(stencil.offsets):
        goal = cells + offset
        outside = np.any((goal < 0) | (goal >= np.asarray(shape)), axis=1)
        shares[outside, d] = 1.0 if tau is None else tau[(d, *cells[outside].T)]
    return shares


def border_cells(shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Cells (M, dimension) at the grid's border."""
    edge = np.zeros(shape, bool)
    for axis, count in enumerate(shape):
        np.moveaxis(edge, axis, 0)[[0, count - 1]] = True
    return np.argwhere(edge)


def border_weights(stencil: Stencil, shares: Array) -> Array:
    """Flux (M, components) that leaves per unit of each coefficient."""
    return np.asarray(shares @ significant(stencil.transfer)[:, 0])
