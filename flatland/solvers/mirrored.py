"""The inverse of a stencil between mirrors, by fast sine and cosine transforms."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from flatland.kernels.orbits import significant
from flatland.kernels.threads import thread_count
from flatland.stencil import Stencil

Array = NDArray[np.float64]
Waves = NDArray[np.float32]

#: Numbers in a field above which two threads transform it faster than one.
_WORTH_SHARING = 2**17
#: Inverses this many times larger than that of the slowest wave of a scheme that diffuses belong
#: to waves that the mirrors keep for ever.
_ENDLESS = 1e3
#: Keeps the inverse of such a wave's block finite until it is found out.
_TINY = 1e-11


class Mirrored:
    """(1 − A)⁻¹ of light that is mirrored, with a minus sign, in planes next to the grid.

    The mirror image of a field turns light over and takes it away, so that what has no direction
    is zero on the planes, as outside the grid. Such fields are sums of sines and cosines along
    each axis, sines for components that are even under that mirror, and a stencil that is the same
    in every cell, and its own mirror image, couples only components of the same wave: 1 − A is
    made of (size, size) blocks, inverted once. (Fast transforms for such boundaries: Strang 1999,
    "The discrete cosine transform"; with odd images as preconditioners Bini & Di Benedetto 1990.)

    Fields are kept with one cell of the lower mirror in front and all up to the upper one behind,
    (size, *cells), in single precision.

    endless: waves (W, dimension), as numbers along each axis, whose blocks have no inverse: light
    between mirrors may run for ever. They get the inverse of 2 − A; `missing` (W, size, size) is
    1 − (1 − A) times that, what is still to be made up for them.
    """

    def __init__(self, stencil: Stencil, shape: tuple[int, ...]) -> None:
        self.shape, self.size = shape, stencil.basis.size
        self.transfer, self.offsets = significant(stencil.transfer), stencil.offsets
        self.periods = mirror_distances(shape)
        self.parities = stencil.basis.parities
        self.odd = self.parities > 0
        self.norm = math.prod(2 * n for n in self.periods)
        self.inverse, self.endless, self.missing = self._spectrum()

    def field(self) -> Waves:
        return np.zeros((self.size, *(n + 1 for n in self.periods)), np.float32)

    def _spectrum(self) -> tuple[Waves, NDArray[np.int64], Array]:
        """(1 − A)⁻¹ of every wave, (size, size, *waves), over the factor of the transforms."""
        waves = [np.pi * np.arange(n + 1) / n for n in self.periods]
        result = np.empty((self.size, self.size, *map(len, waves)), np.float32)
        limit = _ENDLESS * (max(self.periods) / np.pi) ** 2
        endless, missing = [], []
        # A plane at a time: blocks in double precision are four times as large.
        for i, first in enumerate(waves[0]):
            blocks = self._blocks(first, waves[1:]) + _TINY * np.eye(self.size)
            blocks = np.where(self._absent(i)[..., None, :], np.eye(self.size), blocks)
            inverses = np.linalg.inv(blocks)
            for place in np.argwhere(np.abs(inverses).max(axis=(-2, -1)) > limit):
                block = blocks[tuple(place)]
                inverses[tuple(place)] = kept = np.linalg.inv(block + np.eye(self.size))
                endless.append([i, *place])
                missing.append(np.eye(self.size) - block @ kept)
            result[:, :, i] = np.moveaxis(inverses, (-2, -1), (0, 1)) / self.norm
        shape = (len(endless), len(self.shape))
        size = (len(endless), self.size, self.size)
        return result, np.array(endless, np.int64).reshape(shape), np.reshape(missing, size)

    def _blocks(self, first: float, others: list[Array]) -> Array:
        """1 − A of the waves of one plane, (*others, size, size), real."""
        # e^{ikx} ∓ e^{−ikx} is 2i sin or 2 cos: a factor i for every axis with a sine.
        turn = 1j ** self.odd.sum(axis=1)
        parts = self.transfer * (turn[:, None] / turn)
        mesh = np.stack(np.meshgrid(*others, indexing="ij"), axis=-1)
        phase = mesh @ self.offsets[:, 1:].T + first * self.offsets[:, 0]
        waves = np.concatenate([np.cos(phase), np.sin(phase)], axis=-1)
        # Not by BLAS, whose threads take longer to wake than this takes.
        symbol = np.einsum("...d,dij->...ij", waves, np.concatenate([parts.real, parts.imag]))
        return np.asarray(np.eye(self.size) - symbol)

    def _absent(self, first: int) -> NDArray[np.bool_]:
        """Whether a component has no such wave: a sine of the number 0 or the last one."""
        numbers = [np.array([first]), *(np.arange(n + 1) for n in self.periods[1:])]
        absent = np.zeros((*(len(n) for n in numbers), self.size), bool)
        for axis, (number, period) in enumerate(zip(numbers, self.periods)):
            shape = [1] * absent.ndim
            shape[axis] = len(number)
            absent |= ((number % period) == 0).reshape(shape) & self.odd[:, axis]
        return absent[0]

    def solve(self, field: Waves, extra: Array | None = None) -> tuple[Waves, Array]:
        """(1 − A)⁻¹ of a field, and what is missing of it in endless waves, (W, size).

        extra: (W, size), endless waves that are added to the field, which is lost. Both are
        amplitudes in units that give a field of about length 1 in the L2 norm.
        """
        self.transform(field)
        at = (slice(None), *self.endless.T)
        if extra is not None:
            field[at] += (math.sqrt(self.norm) * extra).T
        amplitudes = field[at].T.astype(float) / math.sqrt(self.norm)
        found = np.einsum("ij...,j...->i...", self.inverse, field)
        self.transform(found)
        return found, np.einsum("wij,wj->wi", self.missing, amplitudes)

    def transform(self, waves: Waves) -> None:
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

    def kernel(self) -> Waves:
        """G(x), (*cells, size, size): what light without mirrors gets to x from the origin.

        Light among all images adds up to (1 − A)⁻¹. Only x ≥ 0: a mirror multiplies entry (i, j)
        by the parities of both components.
        """
        result = np.empty((*(n + 1 for n in self.periods), self.size, self.size), np.float32)
        quarters = self.odd.sum(axis=1)
        for i in range(self.size):
            for j in range(self.size):
                values = self.inverse[i, j].copy()
                differ = self.odd[i] != self.odd[j]
                for axis, odd in enumerate(differ):
                    inner = [slice(None)] * values.ndim
                    inner[axis] = slice(1, -1)
                    if odd:
                        part = fft.dst(values[tuple(inner)], 1, axis=axis)
                        values[...] = 0
                        values[tuple(inner)] = part
                    else:
                        values = fft.dct(values, 1, axis=axis)
                turn = 1j ** (quarters[j] - quarters[i] + differ.sum())
                result[..., i, j] = turn.real * values
        return result


def mirror_distances(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Cells from mirror to mirror, one or two more than the grid has: what transforms faster.

    The lower one lies in cell -1. Distances grow the error that mirrors make: 8 iterations for LPV
    on 256² cells became 18 with mirrors 14 cells away.
    """
    return tuple(min((n + 1, n + 2), key=_largest_factor) for n in shape)


def _largest_factor(number: int) -> int:
    largest, factor = 1, 2
    while number > 1:
        while number % factor == 0:
            largest, number = factor, number // factor
        factor += 1
    return largest


def spectrum_bytes(stencil: Stencil, shape: tuple[int, ...]) -> int:
    """Memory for the spectrum, the kernel and the waves of a stencil."""
    size = stencil.basis.size
    return 4 * (2 * size**2 + 4 * size) * math.prod(n + 1 for n in mirror_distances(shape))
