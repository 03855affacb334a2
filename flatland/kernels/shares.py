"""The transmittance τ of links, in the order in which a sweep reads it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.layout import Layout

#: Couplings up to which a sweep is written out twice, with and without τ.
LARGEST_TWICE = 3000


def is_written_twice(couplings: int) -> bool:
    """Whether cells that no wall is near have a sweep of their own."""
    return couplings <= LARGEST_TWICE


def vectors_of(layout: Layout) -> int:
    """Vectors in a row, the last one perhaps in part."""
    return -(-layout.width // layout.lanes)


def header_of(layout: Layout) -> int:
    """Numbers in front of the first block: one per vector, filled up to a whole vector."""
    return -(-layout.rows * vectors_of(layout) // layout.lanes) * layout.lanes


def packed_shares(
    offsets: NDArray[np.int64],
    layout: Layout,
    transmittance: NDArray[np.float64],
    everywhere: bool,
) -> NDArray[np.floating]:
    """τ of what arrives in cells that walls are near, and where it lies.

    transmittance: (K, *shape), of what leaves, with the layers of images that the layout has.
    everywhere: in all cells. First, for every vector
    of cells, the number of its block as a 32-bit integer, -1 where all that arrives is open: such
    cells need no τ, and in most scenes most are such. Then blocks (K, lanes), one after another:
    apart, as many streams through memory as there are neighbours, they took three times as long to
    read with 26 of them. A row's last vector has a block if it is not whole.
    """
    vectors, lanes = vectors_of(layout), layout.lanes
    arriving = np.ones((layout.rows, vectors * lanes), layout.dtype)
    view = arriving[:, : layout.width].reshape(layout.shape)
    near = np.full((layout.rows, vectors), everywhere)
    near[:, layout.width // lanes :] = True
    gathered = []
    for share, offset in zip(transmittance, offsets):
        ends = [min(n, all_ + o) for o, n, all_ in zip(offset, layout.shape, share.shape)]
        arrive = tuple(slice(max(0, o), end) for o, end in zip(offset, ends))
        stay = tuple(slice(max(0, -o), end - o) for o, end in zip(offset, ends))
        view[...] = 1
        view[arrive] = share[stay]
        blocks = arriving.reshape(layout.rows, vectors, lanes)
        near |= (blocks != 1).any(axis=2)
        gathered.append(blocks.copy())
    header, count = header_of(layout), int(np.count_nonzero(near))
    buffer = _aligned(header + count * len(offsets) * lanes, layout)
    numbers = np.full(near.shape, -1, np.int32)
    numbers[near] = np.arange(count)
    integers = buffer[:header].view(np.int32).reshape(header, -1)
    integers[: numbers.size, 0] = numbers.ravel()
    body = buffer[header:].reshape(count, len(offsets), lanes)
    for d, blocks in enumerate(gathered):
        body[:, d] = blocks[near]
    return buffer


def _aligned(size: int, layout: Layout) -> NDArray[np.floating]:
    raw = np.zeros(size + layout.lanes, layout.dtype)
    start = (-(raw.ctypes.data // layout.dtype.itemsize)) % layout.lanes
    return raw[start : start + size]
