"""Patches of border and walls: the coarse space that takes care of light from afar."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import linalg
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from flatland.kernels import Sweep
from flatland.kernels.threads import rows_of, run_shared, thread_count
from flatland.solvers.edges import Edges
from flatland.stencil import Stencil

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Cells along the sides of a patch; twice as many, until unknowns are few enough to be factorised:
#: so many, times the square root of those of the grid, between these limits.
SIDE = 4
_SHARE, _LEAST, _MOST = 7.0, 4000, 10_500
#: Unknowns of all cells up to which each is a patch of its own: 128² cells with some walls and 2
#: bands. Their factors take 0.2 to 0.3 s, and then a light takes 2 iterations instead of 20 to 50.
_ALL = 3600
#: Components that keep less than this share of themselves in a step matter next to a patch only.
_LASTING = 0.3
#: A link that lets more than this through joins two cells of a block to one patch.
_OPEN = 0.5
#: Patches this many times their side away act from their middle.
_FAR = 2.0
_FAST = {"reassoc", "contract", "nsz"}


def patch_numbers(edges: Edges, sweep: Sweep, side: int, apart: bool = True) -> Integers:
    """Which patch each cell of the edges is in, (M,).

    Cells of a block of side^D cells that light gets between without leaving the block: those on
    the two sides of a wall are apart. apart: False takes the blocks as they are.
    """
    if not apart:
        return np.unique(edges.cells // side, axis=0, return_inverse=True)[1].ravel()
    shape = np.array(sweep.layout.shape)
    number = np.full(shape, -1)
    number[tuple(edges.cells.T)] = np.arange(len(edges.cells))
    pairs = []
    for d, offset in enumerate(sweep.stencil.offsets):
        goal = edges.cells + offset
        inside = np.all((goal >= 0) & (goal < shape), axis=1)
        one = np.flatnonzero(inside)
        other = number[tuple(goal[inside].T)]
        joined = (other >= 0) & np.all(edges.cells[one] // side == goal[inside] // side, axis=1)
        if sweep.open_share is not None:
            joined &= sweep.open_share[(d, *edges.cells[one].T)] > _OPEN
        pairs.append((one[joined], other[joined]))
    ones, others = (np.concatenate(part) for part in zip(*pairs))
    graph = csr_array((np.ones(len(ones)), (ones, others)), shape=(len(edges.cells),) * 2)
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def lasting_components(stencil: Stencil) -> Integers:
    """Components that light far from where it started is made of."""
    return np.flatnonzero(np.diag(stencil.transfer.sum(axis=0)) > _LASTING)


def largest_count(sweep: Sweep) -> int:
    """Unknowns that patches may have."""
    unknowns = sweep.layout.components * sweep.layout.rows * sweep.layout.width
    return int(np.clip(_SHARE * math.sqrt(unknowns), _LEAST, _MOST))


class Patches:
    """The operator 1 + (A between mirrors − A) (1 − A between mirrors)⁻¹ between patches.

    One unknown per patch and component, the same in all its cells, of length 1. Light between
    patches far apart starts in their middles. Where cells are few, each is a patch with all its
    components, and the factors are those of the whole operator, but for endless waves.
    """

    def __init__(self, edges: Edges, sweep: Sweep) -> None:
        self.edges, mirrored = edges, edges.mirrored
        self.size, self.kept = mirrored.size, lasting_components(sweep.stencil)
        self.numbers, side = self._divided(sweep)
        if len(edges.cells) * self.size <= _ALL:
            self.kept, side = np.arange(self.size), 1
            self.numbers = np.arange(len(edges.cells))
        #: Whether the factors are those of all that there is to solve for.
        self.whole = side == 1 and not len(mirrored.endless)
        counts = np.bincount(self.numbers)
        self.count = len(counts)
        self.weights = 1 / np.sqrt(counts[self.numbers])
        self.unknowns = self.count * len(self.kept)
        self.gather = csr_array(
            (self.weights, (self.numbers, np.arange(len(self.numbers)))),
            shape=(self.count, len(self.numbers)),
        )
        matrix = self._between(side)
        matrix.reshape(-1)[:: self.unknowns + 1] += 1
        self.factors = linalg.lu_factor(matrix, overwrite_a=True, check_finite=False)

    def _divided(self, sweep: Sweep) -> tuple[Integers, int]:
        """The smallest patches that are few enough, and their side.

        Among very many walls, patches that are apart do not get fewer as they grow.
        """
        sides = [SIDE * 2**i for i in range(max(sweep.layout.shape).bit_length())]
        for apart, side in itertools.product((True, False), sides):
            numbers = patch_numbers(self.edges, sweep, side, apart)
            if (numbers.max(initial=-1) + 1) * len(self.kept) <= largest_count(sweep):
                break
        return numbers, side

    def _between(self, side: int) -> NDArray[np.float32]:
        starts, rows, blocks = self._stopped()
        mirrored = self.edges.mirrored
        order = np.argsort(self.numbers, kind="stable")
        first = np.searchsorted(self.numbers[order], np.arange(self.count + 1))
        cells = self.edges.cells[order].astype(np.int64)
        middles = np.add.reduceat(cells, first[:-1], axis=0) / np.diff(first)[:, None]
        kernel = mirrored.kernel()
        cells_of_kernel = np.array(kernel.shape[: cells.shape[1]])
        kept = len(self.kept)
        result = np.zeros((self.count, kept, self.count, kept), np.float32)
        given = (
            starts, rows, blocks[:, self.kept].astype(np.float32), cells, first,
            np.rint(middles).astype(int),
            np.ascontiguousarray(kernel.reshape(-1, self.size, self.size)[..., self.kept]),
            cells_of_kernel, np.ascontiguousarray(_signs(mirrored.parities)[..., self.kept]),
            _FAR * side,
        )  # fmt: skip

        def part(party: int, running: int) -> None:
            _add_light(*given, result, *rows_of(party, running, self.count))

        run_shared(part, thread_count())
        return result.reshape(self.unknowns, self.unknowns)

    def _stopped(self) -> tuple[Integers, Integers, Array]:
        """Cells (L, dimension) that light comes from, patches (L,) that it is missed in or comes
        back to, and how much of it (L, size, size), each pair once."""
        edges = self.edges
        starts, rows, blocks = [], [], []
        for links, transfer, offset in zip(edges.links, edges.transfer, edges.mirrored.offsets):
            starts.append(edges.cells[links.rows] - offset)
            rows.append(links.rows)
            blocks.append(links.share[:, None, None] * transfer)
        starts.append(edges.cells[edges.local_rows])
        rows.append(edges.local_rows)
        blocks.append(-edges.local)
        row = np.concatenate(rows)
        all_blocks = self.weights[row][:, None, None] * np.concatenate(blocks)
        keys = np.column_stack([np.concatenate(starts), self.numbers[row]])
        pairs, place = np.unique(keys, axis=0, return_inverse=True)
        summed = np.zeros((len(pairs), self.size, self.size))
        np.add.at(summed, place.ravel(), all_blocks)
        return np.ascontiguousarray(pairs[:, :-1]), pairs[:, -1].copy(), summed

    def precondition(self, values: Array, answer: Array) -> None:
        """answer = values, with the patches' part replaced by that of the inverse.

        values: those of the cells (M, size), then those of endless waves, as one vector; the
        latter stay.
        """
        end = len(self.numbers) * self.size
        cells = values[:end].reshape(-1, self.size)
        coarse = (self.gather @ cells[:, self.kept]).ravel()
        single = coarse.astype(np.float32)
        change = linalg.lu_solve(self.factors, single, check_finite=False) - coarse
        answer[:] = values
        spread = change.reshape(self.count, -1)[self.numbers]
        answer[:end].reshape(cells.shape)[:, self.kept] += self.weights[:, None] * spread


def _signs(parities: Integers) -> NDArray[np.float32]:
    """Factor of G(|x|)[i, j] for x turned round along some axes, from a cell mirrored along some.

    (turned, mirrored, size, size), both as bits, one per axis.
    """
    dimension = parities.shape[1]
    both = np.einsum("ia,ja->aij", parities, parities)
    result = np.ones((2**dimension, 2**dimension, len(parities), len(parities)), np.float32)
    for turned, mirrored in itertools.product(range(2**dimension), repeat=2):
        for axis in range(dimension):
            if turned >> axis & 1:
                result[turned, mirrored] *= both[axis]
            if mirrored >> axis & 1:
                result[turned, mirrored] *= -parities[:, axis]
    return result


@njit(cache=True, fastmath=_FAST, nogil=True)
def _add_light(  # type: ignore[no-untyped-def]
    starts, rows, blocks, cells, first, middles, kernel, extent, signs, far, result, begin, end
):
    """result[row, :, b, :] += block · Σ (light that gets to start from the cells of patch b).

    For patches from begin to end (excluded).
    """
    kept, size = blocks.shape[1], blocks.shape[2]
    dimension = cells.shape[1]
    light = np.empty((end - begin, size, kept), np.float32)
    for m in range(rows.size):
        new = m == 0
        for a in range(dimension):
            new = new or starts[m, a] != starts[m - 1, a]
        if new:
            light[:] = 0
            for b in range(begin, end):
                number = first[b + 1] - first[b]
                for mirrored in range(2**dimension):
                    away = 0
                    for a in range(dimension):
                        place = middles[b, a]
                        if mirrored >> a & 1:
                            place = -2 - place
                        away = max(away, _apart(starts[m, a] - place, extent[a] - 1))
                    whole = away <= far
                    for c in range(number if whole else 1):
                        turned, at = 0, 0
                        for a in range(dimension):
                            place = cells[first[b] + c, a] if whole else middles[b, a]
                            if mirrored >> a & 1:
                                place = -2 - place
                            period = 2 * (extent[a] - 1)
                            step = (starts[m, a] - place) % period
                            if step >= extent[a]:
                                step = period - step
                                turned |= 1 << a
                            at = at * extent[a] + step
                        weight = np.float32((1.0 if whole else number) / np.sqrt(number))
                        for i in range(size):
                            for j in range(kept):
                                sign = signs[turned, mirrored, i, j]
                                light[b - begin, i, j] += weight * sign * kernel[at, i, j]
        for b in range(begin, end):
            for i in range(kept):
                for j in range(kept):
                    total = np.float32(0.0)
                    for k in range(size):
                        total += blocks[m, i, k] * light[b - begin, k, j]
                    result[rows[m], i, b, j] += total


@njit(cache=True)
def _apart(step, half):  # type: ignore[no-untyped-def]
    """Cells between two places on a circle of 2·half."""
    step = step % (2 * half)
    return min(step, 2 * half - step)
