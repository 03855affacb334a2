"""The inverse of a stencil between mirrors, with walls smeared out, as a preconditioner."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from flatland.harmonics import AngularBasis
from flatland.kernels import Sweep
from flatland.kernels.threads import thread_count
from flatland.memory import available_memory
from flatland.solvers.vectors import squares

Array = NDArray[np.float64]

#: Light lost in a step, times the cells along the longest side: 1 − A between mirrors may have no
#: inverse. Best of 0.01 … 1 over LPV and DOM, with and without walls.
LOSS = 0.1
#: Spectra take this part of the free memory at most.
SHARE_OF_MEMORY = 0.25
#: Numbers in a field above which two threads transform it faster than one.
_WORTH_SHARING = 2**17


class Mirrored:
    """(1 − A)⁻¹ of light that is mirrored, with a minus sign, in planes next to the grid.

    The mirror image of a field turns light over and takes it away, so that what has no direction
    is zero on the planes, as outside the grid. Such fields are sums of sines and cosines along
    each axis, sines for components that are even under that mirror, and a stencil that is the same
    in every cell, and its own mirror image, couples only components of the same wave: 1 − A is
    made of (size, size) blocks, inverted once. (Preconditioners by fast transforms: Strang 1986
    with periodic images, Bini & Di Benedetto 1990 with odd ones.)

    Walls enter by their mean over the grid, as in the circulant matrix nearest to an operator
    (Chan 1988): transmittance by its mean along each offset, reflection by its mean in a cell.
    What is left is the part of the border that mirrors get wrong, and single walls: less than the
    grid by a dimension, so that iterations grow slowly with its size, for schemes that diffuse
    (LPV) and for those that carry light straight on (DOM), which coarse grids do not see.
    Single precision: a preconditioner needs no more.

    What it gets wrong: single walls are not seen, and many of them cost iterations.
    """

    def __init__(self, sweep: Sweep) -> None:
        self.layout = sweep.layout
        self.periods = mirror_distances(self.layout.shape)
        self.odd = component_parities(sweep.stencil.basis) > 0
        self._inverse = self._spectrum(sweep)
        self._waves = np.zeros((len(self.odd), *(n + 1 for n in self.periods)), np.float32)

    def _spectrum(self, sweep: Sweep) -> NDArray[np.float32]:
        """(1 − A)⁻¹ of every wave, (size, size, *waves), over the factor of the transforms."""
        stencil, size = sweep.stencil, sweep.stencil.basis.size
        transfer, local = mean_operator(sweep)
        transfer = (1 - LOSS / max(self.layout.shape)) * transfer
        # e^{ikx} ∓ e^{−ikx} is 2i sin or 2 cos: a factor i for every axis with a sine.
        turn = 1j ** self.odd.sum(axis=1)
        waves = [np.pi * np.arange(n + 1) / n for n in self.periods]
        result = np.empty((size, size, *map(len, waves)), np.float32)
        others = np.stack(np.meshgrid(*waves[1:], indexing="ij"), axis=-1)
        phases = np.exp(-1j * (others @ stencil.offsets[:, 1:].T))
        norm = math.prod(2 * n for n in self.periods)
        # A plane at a time: blocks in double precision are four times as large.
        for i, first in enumerate(waves[0]):
            turned = phases * np.exp(-1j * first * stencil.offsets[:, 0])
            symbol = np.tensordot(turned, transfer, 1) * (turn[:, None] / turn)
            blocks = np.eye(size) - local - symbol.real
            result[:, :, i] = np.moveaxis(np.linalg.inv(blocks), (-2, -1), (0, 1)) / norm
        return result

    def precondition(self, right: Array, answer: Array) -> None:
        """Write an approximate solution of (1 − A) x = right into `answer`."""
        # Kept near 1: a residual of 1e-40 would be lost in single precision.
        total = squares(right)
        size = math.sqrt(total / right.size) if total > 0 else 1.0
        inside = (slice(None), *(slice(1, 1 + n) for n in self.layout.shape))
        waves = self._waves
        waves[...] = 0
        np.multiply(self.layout.view(right), 1 / size, out=waves[inside], casting="same_kind")
        self._transform(waves)
        found = np.einsum("ij...,j...->i...", self._inverse, waves)
        self._transform(found)
        np.multiply(found[inside], size, out=self.layout.view(answer))

    def _transform(self, waves: NDArray[np.float32]) -> None:
        """Sines or cosines along every axis, in place; twice in a row, it is the `norm`."""
        workers = thread_count() if waves.size > _WORTH_SHARING else 1
        for axis in range(len(self.periods)):
            inner = [slice(None)] * len(self.periods)
            inner[axis] = slice(1, -1)
            for component, odd in zip(waves, self.odd[:, axis]):
                if odd:
                    part = component[tuple(inner)]
                    part[...] = fft.dst(part, 1, axis=axis, workers=workers)
                else:
                    component[...] = fft.dct(component, 1, axis=axis, workers=workers)


def mirror_distances(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Cells from mirror to mirror: at least one more than the grid has, and fast to transform.

    The lower one lies in cell -1.
    """
    return tuple(fft.next_fast_len(cells + 1, real=True) for cells in shape)


def component_parities(basis: AngularBasis) -> NDArray[np.int64]:
    """±1 per component and axis (size, dimension): its sign when that axis is turned round."""
    generator = np.random.default_rng(0)
    directions = generator.normal(size=(4 * basis.size, basis.dimension))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    plain = basis.evaluate(directions)
    signs = []
    for axis in range(basis.dimension):
        mirror = np.ones(basis.dimension)
        mirror[axis] = -1
        signs.append(np.sign(np.sum(plain * basis.evaluate(directions * mirror), axis=0)))
    return np.stack(signs, axis=1).astype(np.int64)


def spectrum_bytes(sweep: Sweep) -> int:
    """Memory for the spectrum and the waves of a sweep."""
    size = sweep.stencil.basis.size
    return 4 * (size**2 + 3 * size) * math.prod(n + 1 for n in mirror_distances(sweep.layout.shape))


def is_affordable(sweep: Sweep) -> bool:
    """Whether the spectrum fits into its share of the free memory."""
    return spectrum_bytes(sweep) <= SHARE_OF_MEMORY * available_memory()


def mean_operator(sweep: Sweep) -> tuple[Array, Array]:
    """Mean transfer (K, size, size) along each offset, and mean of what stays (size, size)."""
    stencil, open_share = sweep.stencil, sweep.open_share
    transfer = stencil.transfer
    if open_share is not None:
        transfer = open_share.reshape(len(transfer), -1).mean(axis=1)[:, None, None] * transfer
    local = np.zeros(transfer.shape[1:])
    if sweep.reflection is not None:
        local += sweep.reflection.blocks(stencil).sum(axis=0) / math.prod(sweep.layout.shape)
    return transfer, local
