"""Ways to an answer of (1 − A) S_A = S_0; none of them promises one."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np

from flatland.kernels import Sweep
from flatland.kernels.reports import Buffer
from flatland.solvers.aggregation import Aggregation
from flatland.solvers.bicgstab import Operator, bicgstab
from flatland.solvers.factorization import factorization, factorization_key
from flatland.solvers.gcr import gcr
from flatland.solvers.multigrid import Multigrid
from flatland.solvers.problem import Problem
from flatland.solvers.reduced import Reduced
from flatland.solvers.vectors import norm

#: Iterations after which a Krylov method is taken to have stalled.
_MULTIGRID_ITERATIONS = 30
_KRYLOV_ITERATIONS = 4000
_AGGREGATION_ITERATIONS = 60
#: Part of the residual that a correction by transforms may leave.
_LEAST_GAIN = 0.7
_STEPPING_SWEEPS = 20_000
_STEPPING_BATCH = 16
#: Memory for what is kept of operators, by each of the methods that set something up.
_KEPT_BYTES = 2**30


class _Sized(Protocol):
    @property
    def bytes(self) -> int:
        """Memory that is kept."""


Key = tuple[object, ...]
Kept = TypeVar("Kept", bound=_Sized)
_reduced: OrderedDict[Key, Reduced] = OrderedDict()
_cycles: OrderedDict[Key, Multigrid] = OrderedDict()
_groups: OrderedDict[Key, Aggregation] = OrderedDict()


def prepare(problem: Problem, method: str) -> None:
    """Compile and set up, once, what a method needs, so that it is not timed."""
    sweep = problem.sweep
    if method in sweep.prepared:
        return
    sweep.prepared.add(method)
    if method == "multigrid":
        cycles = _cycles_for(sweep)
        cycles.precondition(problem.right, sweep.layout.allocate())
    if method == "mirrored":
        _reduced_for(sweep)
    if method == "aggregation":
        _groups_for(sweep).precondition(problem.right, sweep.layout.allocate())
    bicgstab(problem.apply, _copy, problem.right, 0.5, 1)
    problem.applications = 0


def run(problem: Problem, method: str, tolerance: float) -> Buffer:
    """An answer by one of the methods, to a residual relative to the light."""
    left = norm(problem.right)
    wanted = tolerance * norm(problem.light)
    if left <= wanted:
        values = problem.sweep.layout.allocate()
    else:
        values = _RUN[method](problem, wanted / left)
    if problem.start is not None:
        values += problem.start
    if problem.lighted is not None:
        problem.sweep.layout.view(values)[:, ~problem.lighted] = 0.0
    return values


def _multigrid(problem: Problem, tolerance: float) -> Buffer:
    cycles = _cycles_for(problem.sweep)
    before = cycles.applications
    answer = _bicgstab(problem, tolerance, cycles.precondition, _MULTIGRID_ITERATIONS)
    problem.applications += cycles.applications - before
    return answer


def _aggregation(problem: Problem, tolerance: float) -> Buffer:
    groups = _groups_for(problem.sweep)
    before = groups.applications
    outcome = gcr(
        problem.apply,
        groups.precondition,
        problem.right,
        0.5 * tolerance,
        _AGGREGATION_ITERATIONS,
    )
    problem.iterations += outcome.iterations
    problem.applications += groups.applications - before
    return outcome.answer


def _mirrored(problem: Problem, tolerance: float) -> Buffer:
    """Corrections by transforms, until they do not gain any more."""
    reduced = _reduced_for(problem.sweep)
    goal, before = tolerance * norm(problem.right), np.inf
    answer, rest = problem.sweep.layout.allocate(), problem.right.copy()
    while goal < (left := norm(rest)) < _LEAST_GAIN * before:
        before, best = left, answer.copy()
        iterations = reduced.correct(rest, answer, 0.5 * goal)
        problem.iterations += iterations
        # An application in the cells of the edges alone counts as a whole one; to start a
        # correction and to check the space it was found in takes two more.
        problem.applications += iterations + 2
        problem.apply(answer, rest)
        np.subtract(problem.right, rest, out=rest)
    return answer if left < before else best


def _krylov(problem: Problem, tolerance: float) -> Buffer:
    return _bicgstab(problem, tolerance, _copy, _KRYLOV_ITERATIONS)


def _stepping(problem: Problem, tolerance: float) -> Buffer:
    """The sum over steps itself: best where light soon leaves the grid."""
    layout = problem.sweep.layout
    source, answer, target = problem.right.copy(), problem.right.copy(), layout.allocate()
    goal = tolerance * norm(problem.right)
    for _ in range(_STEPPING_SWEEPS // _STEPPING_BATCH):
        sums = problem.sweep.steps(source, target, answer, _STEPPING_BATCH)
        problem.iterations += _STEPPING_BATCH
        problem.count(_STEPPING_BATCH)
        if not sums.squares[-1] > (0.5 * goal) ** 2:
            break
    return answer


def _factorization(problem: Problem, tolerance: float) -> Buffer:
    sweep = problem.sweep
    factors = factorization(sweep.stencil, sweep.layout.shape, sweep.open_share, sweep.reflection)
    cells = np.moveaxis(sweep.layout.view(problem.right), 0, -1)
    values = factors.solve(np.ascontiguousarray(cells).ravel()).reshape(cells.shape)
    answer = sweep.layout.allocate()
    sweep.layout.view(answer)[...] = np.moveaxis(values, -1, 0)
    return answer


_RUN: dict[str, Callable[[Problem, float], Buffer]] = {
    "multigrid": _multigrid,
    "aggregation": _aggregation,
    "mirrored": _mirrored,
    "stepping": _stepping,
    "krylov": _krylov,
    "factorization": _factorization,
}


def _bicgstab(problem: Problem, tolerance: float, precondition: Operator, limit: int) -> Buffer:
    outcome = bicgstab(problem.apply, precondition, problem.right, 0.5 * tolerance, limit)
    problem.iterations += outcome.iterations
    return outcome.answer


def _copy(source: Buffer, target: Buffer) -> None:
    target[:] = source


def _cycles_for(sweep: Sweep) -> Multigrid:
    """The multigrid hierarchy of a stencil on a grid; walls are not in it, so all colours share it.

    Apart for each thread, since it holds the fields it works on.
    """
    key = (threading.get_ident(), *factorization_key(sweep.stencil, sweep.layout.shape, None))
    return _kept(_cycles, key, lambda: Multigrid(sweep.stencil, sweep.layout.shape))


def _groups_for(sweep: Sweep) -> Aggregation:
    """The groups of cells of an operator, apart for each thread."""
    return _kept(_groups, (threading.get_ident(), *_key(sweep)), lambda: Aggregation(sweep))


def _reduced_for(sweep: Sweep) -> Reduced:
    """What transforms need of an operator."""
    return _kept(_reduced, _key(sweep), lambda: Reduced(sweep))


def _key(sweep: Sweep) -> Key:
    return factorization_key(sweep.stencil, sweep.layout.shape, sweep.open_share, sweep.reflection)


def _kept(store: OrderedDict[Key, Kept], key: Key, make: Callable[[], Kept]) -> Kept:
    """What is kept for other lights, or made; the oldest go when all take too much memory."""
    if key not in store:
        store[key] = make()
    store.move_to_end(key)
    while len(store) > 1 and sum(each.bytes for each in store.values()) > _KEPT_BYTES:
        store.popitem(last=False)
    return store[key]
