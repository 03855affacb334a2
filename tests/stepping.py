"""Steps on plain arrays (size, *shape): written for the reader, and the engine's."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from flatland.kernels import Layout, Sweep
from flatland.stencil import Stencil


@dataclass
class PlainStep:
    """What one step does: the light that arrives (size, *shape), and fluxes in all.

    Fluxes are in units of coefficient 0. sent: by all cells. left: over the border. absorbed:
    stopped on the way.
    """

    arrived: np.ndarray
    sent: float
    left: float
    absorbed: float


def plain_step(stencil, values, transmittance=None):
    """S_{i+1}(x + d) += τ(x, d) T_d S_i(x), on a grid with one more cell on every side."""
    shape = values.shape[1:]
    wide = np.zeros((len(values), *(n + 2 for n in shape)))
    sent = absorbed = 0.0
    for d, offset in enumerate(stencil.offsets):
        light = outgoing(stencil, d, values)
        share = np.ones(shape) if transmittance is None else transmittance[d]
        place = tuple(slice(1 + o, 1 + o + n) for o, n in zip(offset, shape))
        wide[(slice(None), *place)] += share * light
        sent += light[0].sum()
        absorbed += ((1 - share) * light[0]).sum()
    inner = tuple(slice(1, -1) for _ in shape)
    arrived = wide[(slice(None), *inner)].copy()
    return PlainStep(arrived, sent, wide[0].sum() - arrived[0].sum(), absorbed)


def outgoing(stencil, d, values):
    """What all cells send along offset d (size, *shape), nothing in the way."""
    if not stencil.clamp:
        return np.einsum("jk,k...->j...", stencil.transfer[d], values)
    fluxes = np.einsum("fk,k...->f...", stencil.reception[d], values)
    return np.einsum("jf,f...->j...", stencil.emission[d], np.maximum(fluxes, 0.0))


def plain_run(stencil, values, count, transmittance=None):
    """The light after every step, [S_0, …, S_count], and the steps [PlainStep]."""
    states, steps = [values], []
    for _ in range(count):
        steps.append(plain_step(stencil, states[-1], transmittance))
        states.append(steps[-1].arrived)
    return states, steps


def operator(stencil, shape, transmittance=None):
    """A as a sparse matrix over unknowns ordered (coefficient, cell), by Kronecker products."""
    cells = int(np.prod(shape))
    total = sparse.csr_array((cells * stencil.basis.size,) * 2)
    for d, offset in enumerate(stencil.offsets):
        shift = sparse.eye_array(1)
        for n, o in zip(shape, offset):
            along = sparse.eye_array(n, k=-o) if abs(o) < n else sparse.csr_array((n, n))
            shift = sparse.kron(shift, along)
        share = np.ones(cells) if transmittance is None else transmittance[d].ravel()
        total = total + sparse.kron(stencil.transfer[d], shift @ sparse.diags_array(share))
    return total.tocsr()


class Stepper:
    """A compiled sweep that takes and gives plain arrays (size, *shape)."""

    def __init__(self, stencil, shape, transmittance=None, sums=(0,), dtype=np.float64):
        self.layout = Layout(tuple(shape), stencil.basis.size, np.dtype(dtype))
        self.sweep = Sweep(stencil, self.layout, transmittance, sums)

    def buffer(self, values=0.0):
        buffer = self.layout.allocate()
        self.layout.view(buffer)[...] = values
        return buffer

    def steps(self, values, count=1):
        """Newest light, sum of all light that arrived, and what the steps report."""
        source, target, total = self.buffer(values), self.buffer(), self.buffer()
        sums = self.sweep.steps(source, target, total, count)
        newest = target if count % 2 else source
        return self.layout.view(newest).copy(), self.layout.view(total).copy(), sums

    def step(self, values):
        """The light after one step."""
        return self.steps(values)[0]


def random_stencil(rng, basis, offsets, faces=0, clamp=False):
    """A made-up scheme whose light stays near its size; with `faces`, one that can be clamped."""
    count, size = len(offsets), basis.size
    if not faces:
        return Stencil(basis, offsets, rng.normal(size=(count, size, size)) / (count * size) ** 0.5)
    reception = rng.normal(size=(count, faces, size)) / size**0.5
    emission = rng.normal(size=(count, size, faces)) / (count * faces) ** 0.5
    return Stencil.from_faces(basis, offsets, reception, emission, clamp)


def neighbours(dimension, diagonal=True):
    """Offsets to all neighbours of a cell, or to the axial ones alone."""
    offsets = np.argwhere(np.ones((3,) * dimension)) - 1
    length = np.abs(offsets).sum(axis=1)
    return offsets[length > 0 if diagonal else length == 1]
