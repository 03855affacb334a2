"""A sparse factorisation of 1 − A, for many lights in one small scene."""

from __future__ import annotations

from collections import OrderedDict
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import SuperLU, splu

from flatland.errors import bad_input
from flatland.kernels.orbits import significant
from flatland.kernels.reflection import Reflection
from flatland.stencil import Stencil

Array = NDArray[np.float64]

#: Unknowns above which fill-in makes a factorisation slower than the Krylov methods.
LARGEST = 300_000
_KEPT = 4
_factors: OrderedDict[tuple[object, ...], SuperLU] = OrderedDict()


def operator_matrix(
    stencil: Stencil,
    shape: tuple[int, ...],
    transmittance: Array | None = None,
    reflection: Reflection | None = None,
) -> csc_array:
    """1 − A as a sparse matrix over unknowns ordered (cell, coefficient).

    What walls send back is part of A: a block on the diagonal of every cell it touches.
    """
    cells = int(np.prod(shape))
    size = stencil.basis.size
    number = np.arange(cells).reshape(shape)
    result = eye_array(cells * size, format="csc")
    for d, (offset, transfer) in enumerate(zip(stencil.offsets, significant(stencil.transfer))):
        stay = tuple(slice(max(0, -o), n - max(0, o)) for o, n in zip(offset, shape))
        arrive = tuple(slice(max(0, o), n - max(0, -o)) for o, n in zip(offset, shape))
        source, goal = number[stay].ravel(), number[arrive].ravel()
        passing = np.ones(source.size) if transmittance is None else transmittance[d][stay].ravel()
        row, column = np.nonzero(transfer)
        values = np.multiply.outer(passing, transfer[row, column])
        rows = goal[:, None] * size + row
        columns = source[:, None] * size + column
        entries = (values.ravel(), (rows.ravel(), columns.ravel()))
        result = result - csc_array(entries, shape=result.shape)
    if reflection is not None:
        first = size * number[tuple(reflection.cells.T)][:, None, None]
        rows = first + np.arange(size)[:, None] + np.zeros(size, int)
        columns = first + np.arange(size) + np.zeros((size, 1), int)
        entries = reflection.blocks(stencil).ravel(), (rows.ravel(), columns.ravel())
        result = result - csc_array(entries, shape=result.shape)
    return result.tocsc()


def factorization(
    stencil: Stencil,
    shape: tuple[int, ...],
    transmittance: Array | None = None,
    reflection: Reflection | None = None,
) -> SuperLU:
    """The factors of 1 − A; the last few are kept, so that moving a light costs a solve only.

    Raises InputError for a grid with too many unknowns to factorise.
    """
    key = factorization_key(stencil, shape, transmittance, reflection)
    if key in _factors:
        _factors.move_to_end(key)
        return _factors[key]
    unknowns = int(np.prod(shape)) * stencil.basis.size
    if len(shape) != 2 or unknowns > LARGEST:
        rule = f"a factorisation takes 2D grids of at most {LARGEST} unknowns, not {unknowns}"
        raise bad_input("method", "factorization", rule, ("auto", "multigrid", "krylov"))
    factors = splu(operator_matrix(stencil, shape, transmittance, reflection))
    _factors[key] = factors
    if len(_factors) > _KEPT:
        _factors.popitem(last=False)
    return factors


def factorization_key(
    stencil: Stencil,
    shape: tuple[int, ...],
    transmittance: Array | None,
    reflection: Reflection | None = None,
) -> tuple[object, ...]:
    """What makes two operators the same."""
    blocked = b"" if transmittance is None else transmittance.tobytes()
    reflected = b"" if reflection is None else reflection.key
    parts = (stencil.offsets.tobytes(), stencil.transfer.tobytes(), blocked, reflected)
    return (shape, *(blake2b(part).digest() for part in parts))


def is_factorized(
    stencil: Stencil,
    shape: tuple[int, ...],
    transmittance: Array | None,
    reflection: Reflection | None = None,
) -> bool:
    """Whether the factors are at hand."""
    return factorization_key(stencil, shape, transmittance, reflection) in _factors
