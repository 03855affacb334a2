"""The converged field of a linear scheme, and how far it really got."""

from __future__ import annotations

import math
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatland.errors import ConvergenceError, InstabilityError, bad_input
from flatland.kernels import Sweep
from flatland.kernels.reports import Buffer
from flatland.memory import available_memory
from flatland.solvers.bicgstab import Operator, bicgstab
from flatland.solvers.factorization import factorization, factorization_key, is_factorized
from flatland.solvers.growth import growth_factor, may_grow
from flatland.solvers.lighted import lighted_cells, reflection_in
from flatland.solvers.multigrid import Multigrid
from flatland.solvers.reduced import Reduced, diffuses, is_reducible
from flatland.solvers.vectors import dot, norm
from flatland.solvers.watching import applied
from flatland.stability import RADIUS_TOLERANCE
from flatland.symmetry import is_mirror_symmetric

METHODS = ("auto", "multigrid", "mirrored", "stepping", "krylov", "factorization")
#: Iterations after which a Krylov method is taken to have stalled.
_MULTIGRID_ITERATIONS = 30
#: Part of the residual that a correction by transforms may leave.
_LEAST_GAIN = 0.7
#: Cells below which transforms are not worth their set-up.
_WORTH_TRANSFORMS = 4000
#: Share of cells next to a wall, by dimension, above which BiCGSTAB alone is soonest done:
#: in 2D that of 100 segments of 8 cells on 128² cells. Fewer than so many cells are never too many.
_CLUTTERED, _FEW = {2: 0.06, 3: 0.12}, 1000
#: Coefficients above which coarse grids, dense stencils each, take seconds to compile.
_WORTH_MULTIGRID = 5
_KRYLOV_ITERATIONS = 4000
_STEPPING_SWEEPS = 20_000
_STEPPING_BATCH = 16
#: Residual of the last answer, scaled, below which it is begun with; and the part of the free
#: memory that it may be kept in.
_WORTH_KNOWING = 0.1
_SHARE_OF_MEMORY = 0.05
#: Memory for what is kept of operators that transforms have solved.
_KEPT_BYTES = 2**30
_reduced: OrderedDict[tuple[object, ...], Reduced] = OrderedDict()


@dataclass(frozen=True)
class SolveReport:
    """How a converged field was found.

    residual: ‖S_0 − (1 − A) S_A‖ / ‖S_0‖, computed anew from the answer in float64.
    applications: of the finest operator A, those inside the preconditioner included; one in cells
    next to border and walls alone counts as a whole one.
    seconds: of the solution itself; compiling and setting up coarse grids come before.
    """

    method: str
    iterations: int
    applications: int
    residual: float
    tolerance: float
    seconds: float


class _Problem:
    """(1 − A) x = b on padded float64 buffers; the border of zeros stays zero."""

    def __init__(self, sweep: Sweep, right: Buffer) -> None:
        #: Where light gets to; the rest of the answer is zero.
        self.lighted: NDArray[np.bool_] | None = None
        if sweep.reflection is not None:
            self.lighted = lighted_cells(sweep, right)
        self.sweep = _in_double(sweep, self.lighted)
        self.right = self.sweep.layout.allocate()
        self.sweep.layout.view(self.right)[...] = sweep.layout.view(right)
        #: The light whose answer is wanted; `right` is what is left of it to be solved for.
        self.light = self.right
        self.start: Buffer | None = None
        self.applications = 0
        self.iterations = 0

    def start_from_last(self) -> None:
        """Begin with the last answer of this operator, if it holds most of this one."""
        if self.sweep.known is None:
            return
        light, answer = self.sweep.known
        start = dot(light, self.light) / dot(light, light) * answer
        rest = self.sweep.layout.allocate()
        self.apply(start, rest)
        np.subtract(self.light, rest, out=rest)
        if norm(rest) < _WORTH_KNOWING * norm(self.light):
            self.start, self.right = start, rest

    def solve(self, method: str, tolerance: float) -> Buffer:
        """An answer by one of the methods."""
        left = norm(self.right)
        wanted = tolerance * norm(self.light)
        if left <= wanted:
            values = self.sweep.layout.allocate()
        else:
            values = _RUN[method](self, wanted / left)
        if self.start is not None:
            values += self.start
        if self.lighted is not None:
            self.sweep.layout.view(values)[:, ~self.lighted] = 0.0
        return values

    def keep(self, values: Buffer) -> None:
        """Remember an answer for other lights."""
        small = 2 * values.nbytes < _SHARE_OF_MEMORY * available_memory()
        self.sweep.known = (self.light, values) if small and self.light.any() else None

    def prepare(self, method: str) -> None:
        """Compile and set up, once, what a method needs, so that it is not timed."""
        if method in self.sweep.prepared:
            return
        self.sweep.prepared.add(method)
        if method == "multigrid":
            cycles = _cycles_for(self.sweep)
            cycles.precondition(self.right, self.sweep.layout.allocate())
        if method == "mirrored":
            _reduced_for(self.sweep)
        bicgstab(self.apply, _copy, self.right, 0.5, 1)
        self.applications = 0

    def apply(self, values: Buffer, result: Buffer) -> None:
        """(1 − A) x."""
        self.count(1)
        self.sweep.combine(1.0, 0.0, -1.0, values, values, result)

    def count(self, applications: int) -> None:
        self.applications += applications
        applied(applications)

    def residual(self, answer: Buffer) -> float:
        scale = norm(self.light)
        defect = self.sweep.layout.allocate()
        self.sweep.combine(-1.0, 1.0, 1.0, answer, self.light, defect)
        return norm(defect) / scale if scale else 0.0


def solve_converged(
    sweep: Sweep, right: Buffer, answer: Buffer, tolerance: float, method: str = "auto"
) -> SolveReport:
    """Write the solution of (1 − A) S_A = S_0 into `answer`.

    tolerance: bound on the relative residual. method: "multigrid" (BiCGSTAB with a multigrid
    cycle as preconditioner; van der Vorst 1992), "mirrored" (fast transforms, and GMRES at the
    border and on walls alone; see `Reduced`), "stepping", "krylov" (BiCGSTAB alone),
    "factorization" (sparse LU, kept for further lights), or "auto": kept factors if there are any,
    BiCGSTAB where walls are everywhere, multigrid for schemes that diffuse in open 2D grids with
    few bands, else transforms in grids that are worth their set-up, and others in turn where one
    stalls. Works in float64 whatever the fields' precision, and goes on from the last answer where
    the light is nearly the same.

    Raises InstabilityError if the spectral radius exceeds 1, of the scheme or of what reflecting
    walls make of it (the sum over steps then has no limit), ConvergenceError if the tolerance is
    not reached.
    """
    if method not in METHODS:
        raise bad_input("method", method, "is unknown", METHODS)
    if method == "mirrored" and not is_mirror_symmetric(sweep.stencil):
        rule = "needs a scheme that is its own mirror image"
        raise bad_input("method", method, rule, ("auto", "multigrid", "krylov"))
    if not 0 < tolerance < 1:
        raise bad_input("tolerance", tolerance, "must lie between 0 and 1")
    radius = sweep.stencil.spectral_radius()
    if radius > 1 + RADIUS_TOLERANCE:
        message = f"no converged field: the scheme's spectral radius is {radius:.4f}, above 1"
        raise InstabilityError(message)
    problem = _Problem(sweep, right)
    candidates = _candidates(problem.sweep, method)
    problem.prepare(candidates[0])
    begin = time.perf_counter()
    problem.start_from_last()
    for name in candidates:
        values = problem.solve(name, tolerance)
        residual = problem.residual(values)
        if residual <= tolerance:
            break
    sweep.layout.view(answer)[...] = problem.sweep.layout.view(values)
    report = SolveReport(
        name,
        problem.iterations,
        problem.applications,
        residual,
        tolerance,
        time.perf_counter() - begin,
    )
    solved = residual <= tolerance
    sums = solved and name == "stepping"
    if not sums and not (solved and not may_grow(problem.sweep, values)):
        _require_no_growth(problem)
    if not solved:
        message = (
            f"{name} stopped at a relative residual of {residual:.2e}, not {tolerance:.2e}, after "
            f"{report.iterations} iterations; the field reached so far is kept"
        )
        raise ConvergenceError(message)
    problem.keep(values)
    return report


def _require_no_growth(problem: _Problem) -> None:
    """Raise InstabilityError where walls send back more than they get."""
    if problem.sweep.reflection is None:
        return
    growth = growth_factor(problem.sweep, problem.light)
    if growth > 1:
        message = (
            f"no converged field: light grows by a factor {growth:.4f} a step among these walls, "
            "though the scheme is stable without them"
        )
        raise InstabilityError(message)


def _candidates(sweep: Sweep, method: str) -> list[str]:
    """Methods in the order in which they are tried, by what was measured fastest."""
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


def _multigrid(problem: _Problem, tolerance: float) -> Buffer:
    cycles = _cycles_for(problem.sweep)
    before = cycles.applications
    answer = _bicgstab(problem, tolerance, cycles.precondition, _MULTIGRID_ITERATIONS)
    problem.applications += cycles.applications - before
    return answer


def _mirrored(problem: _Problem, tolerance: float) -> Buffer:
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


def _krylov(problem: _Problem, tolerance: float) -> Buffer:
    return _bicgstab(problem, tolerance, _copy, _KRYLOV_ITERATIONS)


def _stepping(problem: _Problem, tolerance: float) -> Buffer:
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


def _factorization(problem: _Problem, tolerance: float) -> Buffer:
    sweep = problem.sweep
    factors = factorization(sweep.stencil, sweep.layout.shape, sweep.open_share, sweep.reflection)
    cells = np.moveaxis(sweep.layout.view(problem.right), 0, -1)
    values = factors.solve(np.ascontiguousarray(cells).ravel()).reshape(cells.shape)
    answer = sweep.layout.allocate()
    sweep.layout.view(answer)[...] = np.moveaxis(values, -1, 0)
    return answer


_RUN: dict[str, Callable[[_Problem, float], Buffer]] = {
    "multigrid": _multigrid,
    "mirrored": _mirrored,
    "stepping": _stepping,
    "krylov": _krylov,
    "factorization": _factorization,
}


def _bicgstab(problem: _Problem, tolerance: float, precondition: Operator, limit: int) -> Buffer:
    outcome = bicgstab(problem.apply, precondition, problem.right, 0.5 * tolerance, limit)
    problem.iterations += outcome.iterations
    return outcome.answer


def _copy(source: Buffer, target: Buffer) -> None:
    target[:] = source


def _cycles_for(sweep: Sweep) -> Multigrid:
    """The multigrid hierarchy of a sweep, built once and kept with it."""
    if sweep.hierarchy is None:
        sweep.hierarchy = Multigrid(sweep.stencil, sweep.layout.shape)
    assert isinstance(sweep.hierarchy, Multigrid)
    return sweep.hierarchy


def _reduced_for(sweep: Sweep) -> Reduced:
    """What transforms need of an operator; the last few are kept, for other lights."""
    key = factorization_key(sweep.stencil, sweep.layout.shape, sweep.open_share, sweep.reflection)
    if key not in _reduced:
        _reduced[key] = Reduced(sweep)
    _reduced.move_to_end(key)
    while len(_reduced) > 1 and sum(each.bytes for each in _reduced.values()) > _KEPT_BYTES:
        _reduced.popitem(last=False)
    return _reduced[key]


def _in_double(sweep: Sweep, lighted: NDArray[np.bool_] | None) -> Sweep:
    """The same sweep in float64, with what reflects in some cells only.

    Kept with the sweep, until other cells are asked for.
    """
    if sweep.reflection is None and sweep.layout.dtype == np.float64:
        return sweep
    key = None if lighted is None else lighted.tobytes()
    if sweep.double is None or sweep.double[0] != key:
        layout = replace(sweep.layout, dtype=np.dtype(np.float64))
        twin = Sweep(sweep.stencil, layout, sweep.open_share)
        if sweep.reflection is not None and lighted is not None:
            twin = twin.reflecting(reflection_in(sweep.reflection, lighted))
        sweep.double = key, twin
    return sweep.double[1]
