"""The converged field of a linear scheme, and how far it really got."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, bicgstab

from flatland.errors import ConvergenceError, InstabilityError, bad_input
from flatland.kernels import Layout, Sweep
from flatland.solvers.factorization import factorization, is_factorized
from flatland.solvers.multigrid import Multigrid
from flatland.stencil import RADIUS_TOLERANCE

Buffer = NDArray[np.floating]

METHODS = ("auto", "multigrid", "krylov", "factorization")
#: Iterations after which a Krylov method is taken to have stalled.
_MULTIGRID_ITERATIONS = 60
_KRYLOV_ITERATIONS = 4000


@dataclass(frozen=True)
class SolveReport:
    """How a converged field was found.

    residual: ‖S_0 − (1 − A) S_A‖ / ‖S_0‖, computed anew from the answer in float64.
    applications: of the finest operator A, those inside the preconditioner included.
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
        if sweep.layout.dtype == np.float64:
            self.sweep = sweep
        else:
            self.sweep = _in_double(sweep)
        self.right = self.sweep.layout.allocate()
        self.sweep.layout.view(self.right)[...] = sweep.layout.view(right)
        # BiCGSTAB holds two products at a time; four in turn are never one too few, and their
        # borders stay zero.
        self._products = itertools.cycle([self.sweep.layout.allocate() for _ in range(4)])
        self.applications = 0
        self.iterations = 0

    def apply(self, values: Buffer) -> Buffer:
        """(1 − A) x."""
        result = next(self._products)
        self.applications += 1
        self.sweep.combine(1.0, 0.0, -1.0, values, values, result)
        return result

    def residual(self, answer: Buffer) -> float:
        scale = float(np.linalg.norm(self.right))
        defect = self.sweep.layout.allocate()
        self.sweep.combine(-1.0, 1.0, 1.0, answer, self.right, defect)
        return float(np.linalg.norm(defect)) / scale if scale else 0.0


def solve_converged(
    sweep: Sweep, right: Buffer, answer: Buffer, tolerance: float, method: str = "auto"
) -> SolveReport:
    """Write the solution of (1 − A) S_A = S_0 into `answer`.

    tolerance: bound on the relative residual. method: "multigrid" (BiCGSTAB with a multigrid
    cycle as preconditioner; van der Vorst 1992), "krylov" (BiCGSTAB alone), "factorization"
    (sparse LU, kept for further lights), or "auto": kept factors if there are any, else multigrid,
    else BiCGSTAB alone where multigrid stalls. Works in float64 whatever the fields' precision.

    Raises InstabilityError if the spectral radius exceeds 1 (the sum over steps then has no
    limit), ConvergenceError if the tolerance is not reached.
    """
    if method not in METHODS:
        raise bad_input("method", method, "is unknown", METHODS)
    if not 0 < tolerance < 1:
        raise bad_input("tolerance", tolerance, "must lie between 0 and 1")
    radius = sweep.stencil.spectral_radius()
    if radius > 1 + RADIUS_TOLERANCE:
        message = f"no converged field: the scheme's spectral radius is {radius:.4f}, above 1"
        raise InstabilityError(message)
    begin = time.perf_counter()
    problem = _Problem(sweep, right)
    for name in _candidates(sweep, method):
        values = _RUN[name](problem, tolerance)
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
    if not residual <= tolerance:
        message = (
            f"{name} stopped at a relative residual of {residual:.2e}, not {tolerance:.2e}, after "
            f"{report.iterations} iterations; the field reached so far is kept"
        )
        raise ConvergenceError(message)
    return report


def _candidates(sweep: Sweep, method: str) -> list[str]:
    if method != "auto":
        return [method]
    if is_factorized(sweep.stencil, sweep.layout.shape, sweep.open_share):
        return ["factorization", "multigrid", "krylov"]
    return ["multigrid", "krylov"]


def _multigrid(problem: _Problem, tolerance: float) -> Buffer:
    cycles = _cycles_for(problem.sweep)
    before = cycles.applications
    answer = _bicgstab(problem, tolerance, cycles.precondition, _MULTIGRID_ITERATIONS)
    problem.applications += cycles.applications - before
    return answer


def _krylov(problem: _Problem, tolerance: float) -> Buffer:
    return _bicgstab(problem, tolerance, None, _KRYLOV_ITERATIONS)


def _factorization(problem: _Problem, tolerance: float) -> Buffer:
    sweep = problem.sweep
    factors = factorization(sweep.stencil, sweep.layout.shape, sweep.open_share)
    cells = np.moveaxis(sweep.layout.view(problem.right), 0, -1)
    values = factors.solve(np.ascontiguousarray(cells).ravel()).reshape(cells.shape)
    answer = sweep.layout.allocate()
    sweep.layout.view(answer)[...] = np.moveaxis(values, -1, 0)
    return answer


_RUN: dict[str, Callable[[_Problem, float], Buffer]] = {
    "multigrid": _multigrid,
    "krylov": _krylov,
    "factorization": _factorization,
}


def _bicgstab(
    problem: _Problem,
    tolerance: float,
    precondition: Callable[[Buffer], Buffer] | None,
    limit: int,
) -> Buffer:
    """SciPy's BiCGSTAB, restarted from its own answer while the true residual lags behind."""
    size = problem.right.size
    operator = LinearOperator((size, size), matvec=problem.apply, dtype=float)
    inner = None
    if precondition is not None:
        inner = LinearOperator((size, size), matvec=precondition, dtype=float)
    answer = np.zeros(size)

    def count(_: Buffer) -> None:
        problem.iterations += 1

    with np.errstate(all="ignore"):
        for _ in range(3):
            answer, _info = bicgstab(
                operator, problem.right, answer, rtol=0.5 * tolerance, atol=0.0,
                maxiter=limit, M=inner, callback=count,
            )  # fmt: skip
            if not problem.residual(answer) > tolerance:
                break
    return np.asarray(answer)


def _cycles_for(sweep: Sweep) -> Multigrid:
    """The multigrid hierarchy of a sweep, built once and kept with it."""
    if sweep.hierarchy is None:
        sweep.hierarchy = Multigrid(sweep.stencil, sweep.layout.shape)
    assert isinstance(sweep.hierarchy, Multigrid)
    return sweep.hierarchy


def _in_double(sweep: Sweep) -> Sweep:
    layout = replace(sweep.layout, dtype=np.dtype(np.float64))
    return Sweep(sweep.stencil, Layout(layout.shape, layout.components, layout.dtype), sweep.open_share)
