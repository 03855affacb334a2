"""Groups of neighbouring unknowns that light gets between, and the operator between groups.

What makes coarse grids of whole blocks fail among walls is that one value stands for both sides of
a wall. Groups end at walls instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from flatland.kernels import Sweep
from flatland.kernels.orbits import significant

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: A link joins two members of a group if it is more than this part of the strongest of either.
_STRONG = 0.25
#: Members whose links together are less than this part of their own share are left to smoothing.
_ALONE = 0.2


@dataclass(frozen=True)
class Groups:
    """labels: (n,), the group of each member, -1 of those left out. places: (groups, dimension)."""

    labels: Integers
    places: Integers

    @property
    def count(self) -> int:
        return len(self.places)


class Links(NamedTuple):
    """Off-diagonal part of an operator on the flux: |entries| (L,) from columns to rows (L,), and
    those of the diagonal (n,)."""

    rows: Integers
    columns: Integers
    sizes: Array
    own: Array


def group(places: Integers, links: Links) -> Groups:
    """Groups of the members of each block of 2^D places, apart where no strong links join them."""
    count = len(places)
    strongest = [np.zeros(count), np.zeros(count)]
    for most, ends in zip(strongest, (links.rows, links.columns)):
        np.maximum.at(most, ends, links.sizes)
    least = np.minimum(strongest[0][links.rows], strongest[1][links.columns])
    sums = [np.bincount(ends, links.sizes, count) for ends in (links.rows, links.columns)]
    kept = np.maximum(*sums) >= _ALONE * links.own
    blocks = places // 2
    number = np.ravel_multi_index(tuple(blocks.T), tuple(1 + blocks.max(axis=0, initial=0)))
    joined = number[links.rows] == number[links.columns]
    joined &= (links.sizes > _STRONG * least) & kept[links.rows] & kept[links.columns]
    rows, columns = links.rows[joined], links.columns[joined]
    graph = coo_array((np.ones(rows.size, bool), (rows, columns)), shape=(count, count))
    parts = connected_components(graph, directed=False)[1]
    labels = np.full(count, -1)
    _, first, labels[kept] = np.unique(parts[kept], return_index=True, return_inverse=True)
    return Groups(labels, blocks[kept][first])


@dataclass(frozen=True)
class BlockMatrix:
    """A sparse matrix of blocks: blocks[e] (size, size) at (rows[e], columns[e]), by rows.

    diagonal: (n,), where the blocks of the diagonal are.
    """

    rows: Integers
    columns: Integers
    blocks: Array
    diagonal: Integers

    def links(self) -> Links:
        own = np.abs(self.blocks[:, 0, 0])
        off = self.rows != self.columns
        return Links(self.rows[off], self.columns[off], own[off], own[self.diagonal])

    def between(self, groups: Groups) -> BlockMatrix:
        """The sum of the blocks between all members of two groups."""
        ends = groups.labels[self.rows], groups.labels[self.columns]
        inside = (ends[0] >= 0) & (ends[1] >= 0)
        rows, columns, pairs = _pairs(ends[0][inside], ends[1][inside], groups.count)
        flat = self.blocks.reshape(len(self.blocks), -1)
        entries = np.ones(pairs.size), (pairs, np.flatnonzero(inside))
        sums = csr_array(entries, shape=(len(rows), len(flat)))
        blocks = np.asarray(sums @ flat).reshape(-1, *self.blocks.shape[1:])
        return BlockMatrix(rows, columns, blocks, np.flatnonzero(rows == columns))


class CellPairs(NamedTuple):
    """Light between the cells of a grid: cells it gets to and comes from (L,), the share of it that
    passes, and which offset it goes along."""

    rows: Integers
    columns: Integers
    shares: Array
    offsets: Integers

    def links(self, sweep: Sweep) -> Links:
        sizes = self.shares * np.abs(sweep.stencil.transfer[self.offsets, 0, 0])
        own = np.ones(sweep.layout.rows * sweep.layout.width)
        return Links(self.rows, self.columns, sizes, own)

    def between(self, groups: Groups, sweep: Sweep) -> BlockMatrix:
        """1 − A summed over the cells of groups, what walls send back included."""
        size, kinds = sweep.stencil.basis.size, len(sweep.stencil.offsets)
        ends = groups.labels[self.rows], groups.labels[self.columns]
        inside = (ends[0] >= 0) & (ends[1] >= 0)
        own = groups.labels[groups.labels >= 0]
        goals, sources = (np.concatenate([end[inside], own]) for end in ends)
        rows, columns, pairs = _pairs(goals, sources, groups.count)
        kind = np.concatenate([self.offsets[inside], np.full(own.size, kinds)])
        shares = np.concatenate([self.shares[inside], np.ones(own.size)])
        weights = np.bincount(pairs * (kinds + 1) + kind, shares, len(rows) * (kinds + 1))
        parts = np.concatenate([-significant(sweep.stencil.transfer), np.eye(size)[None]])
        blocks = weights.reshape(len(rows), -1) @ parts.reshape(kinds + 1, -1)
        diagonal = np.flatnonzero(rows == columns)
        matrix = BlockMatrix(rows, columns, blocks.reshape(-1, size, size), diagonal)
        _take_reflected(matrix, groups, sweep)
        return matrix


def _take_reflected(matrix: BlockMatrix, groups: Groups, sweep: Sweep) -> None:
    """Take what walls send back out of the blocks of the diagonal."""
    if sweep.reflection is None:
        return
    cells = np.ravel_multi_index(tuple(sweep.reflection.cells.T), sweep.layout.shape)
    labels = groups.labels[cells]
    back = sweep.reflection.blocks(sweep.stencil)[labels >= 0]
    np.subtract.at(matrix.blocks, matrix.diagonal[labels[labels >= 0]], back)


def cell_pairs(sweep: Sweep) -> CellPairs:
    shape = sweep.layout.shape
    number = np.arange(np.prod(shape)).reshape(shape)
    parts = []
    for d, offset in enumerate(sweep.stencil.offsets):
        stay = tuple(slice(max(0, -o), n - max(0, o)) for o, n in zip(offset, shape))
        arrive = tuple(slice(max(0, o), n - max(0, -o)) for o, n in zip(offset, shape))
        share = np.ones(shape) if sweep.open_share is None else sweep.open_share[d]
        goals = number[arrive].ravel()
        kinds = np.full(goals.size, d)
        parts.append((goals, number[stay].ravel(), share[stay].ravel(), kinds))
    return CellPairs(*(np.concatenate(column) for column in zip(*parts)))


def _pairs(rows: Integers, columns: Integers, count: int) -> tuple[Integers, Integers, Integers]:
    """Different pairs, by rows, and which of them each pair is."""
    keys, inverse = np.unique(rows * count + columns, return_inverse=True)
    return keys // count, keys % count, inverse
