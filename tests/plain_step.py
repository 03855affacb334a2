"""One step written for the reader: every cell sends, light is added where it arrives."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse


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
