"""Which method a scene is solved with, by what was measured fastest."""

from __future__ import annotations

import math

import numpy as np

from flatland.kernels import Sweep
from flatland.solvers.factorization import is_factorized
from flatland.solvers.reduced import diffuses, is_reducible

METHODS = ("auto", "multigrid", "mirrored", "stepping", "krylov", "factorization")
#: Cells below which transforms are not worth their set-up.
_WORTH_TRANSFORMS = 4000
#: Share of cells next to a wall, by dimension, above which BiCGSTAB alone is soonest done:
#: in 2D that of 100 segments of 8 cells on 128² cells. Fewer than so many cells are never too many.
_CLUTTERED, _FEW = {2: 0.06, 3: 0.12}, 1000
#: Coefficients above which coarse grids, dense stencils each, take seconds to compile.
_WORTH_MULTIGRID = 5


def candidates(sweep: Sweep, method: str) -> list[str]:
    """Methods in the order in which they are tried."""
    if method != "auto":
        return [method]
    operator = sweep.stencil, sweep.layout.shape, sweep.open_share, sweep.reflection
    first = ["factorization"] if is_factorized(*operator) else []
    is_open = sweep.open_share is None and sweep.reflection is None
    flat = len(sweep.layout.shape) == 2 and sweep.layout.components <= _WORTH_MULTIGRID
    fast_multigrid = is_open and flat and diffuses(sweep.stencil)
    if _is_cluttered(sweep):
        return [*first, "krylov", "multigrid", "stepping"]
    if math.prod(sweep.layout.shape) >= _WORTH_TRANSFORMS and is_reducible(sweep):
        rest = ["mirrored", "multigrid", "stepping", "krylov"]
        return first + (["multigrid", *rest] if fast_multigrid else rest)
    return [*first, "multigrid", "stepping", "krylov"]


def _is_cluttered(sweep: Sweep) -> bool:
    """Whether light soon meets a wall wherever it starts, so that no coarse space is needed."""
    if sweep.open_share is None:
        return False
    near = np.count_nonzero((sweep.open_share < 1).any(axis=0))
    shape = sweep.layout.shape
    return bool(near > max(_FEW, _CLUTTERED[len(shape)] * math.prod(shape)))
