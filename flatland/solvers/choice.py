"""Which method a scene is solved with, by what was measured fastest."""

from __future__ import annotations

import math

import numpy as np

from flatland.kernels import Sweep
from flatland.memory import available_memory
from flatland.solvers.aggregation import needed_bytes
from flatland.solvers.factorization import is_factorized
from flatland.solvers.reduced import diffuses, is_reducible

METHODS = (
    "auto", "multigrid", "aggregation", "mirrored", "stepping", "krylov", "factorization"
)  # fmt: skip
#: Cells below which transforms are not worth their set-up.
_WORTH_TRANSFORMS = 4000
#: Share of cells next to a wall, by dimension, above which other methods are sooner done:
#: in 2D that of 100 segments of 8 cells on 128² cells. Fewer than so many cells are never too many.
_CLUTTERED, _FEW = {2: 0.06, 3: 0.12}, 1000
#: Coefficients above which coarse grids, dense stencils each, take seconds to compile.
_WORTH_MULTIGRID = 5
#: Cells of a cluttered 2D grid from which groups are worth their set-up: with 2 bands at 512²
#: they are 2 to 9 times as fast as BiCGSTAB alone, at 256² as fast.
_WORTH_GROUPS = 100_000
#: Part of the free memory that groups may take.
_SHARE_OF_MEMORY = 0.25


def candidates(sweep: Sweep, method: str) -> list[str]:
    """Methods in the order in which they are tried."""
    if method != "auto":
        return [method]
    operator = sweep.stencil, sweep.layout.shape, sweep.open_share, sweep.reflection
    first = ["factorization"] if is_factorized(*operator) else []
    is_open = sweep.open_share is None and sweep.reflection is None
    return [*first, *(_in_the_open(sweep) if is_open else _among_walls(sweep))]


def _in_the_open(sweep: Sweep) -> list[str]:
    flat = len(sweep.layout.shape) == 2 and sweep.layout.components <= _WORTH_MULTIGRID
    rest = ["multigrid", "stepping", "krylov"]
    if not _is_worth_transforms(sweep):
        return rest
    if flat and diffuses(sweep.stencil):
        return ["multigrid", "mirrored", *rest[1:]]
    return ["mirrored", *rest]


def _among_walls(sweep: Sweep) -> list[str]:
    """Multigrid sees no walls; groups do, but need memory. In 3D they are the fastest there is."""
    cluttered, shape = _is_cluttered(sweep), sweep.layout.shape
    transforms = [] if cluttered or not _is_worth_transforms(sweep) else ["mirrored"]
    if needed_bytes(sweep) > _SHARE_OF_MEMORY * available_memory():
        return [*transforms, "krylov", "stepping"]
    if len(shape) == 3:
        return ["aggregation", *transforms, "krylov", "stepping"]
    if not cluttered:
        return [*transforms, "aggregation", "stepping", "krylov"]
    large = math.prod(shape) >= _WORTH_GROUPS
    return [*(["aggregation", "krylov"] if large else ["krylov", "aggregation"]), "stepping"]


def _is_worth_transforms(sweep: Sweep) -> bool:
    return math.prod(sweep.layout.shape) >= _WORTH_TRANSFORMS and is_reducible(sweep)


def _is_cluttered(sweep: Sweep) -> bool:
    """Whether walls are so many that transforms leave no smaller problem."""
    if sweep.open_share is None:
        return False
    near = np.count_nonzero((sweep.open_share < 1).any(axis=0))
    shape = sweep.layout.shape
    return bool(near > max(_FEW, _CLUTTERED[len(shape)] * math.prod(shape)))
