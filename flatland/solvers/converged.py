"""The converged field of a linear scheme, and how far it really got."""

from __future__ import annotations

import time
from dataclasses import dataclass

from flatland.errors import ConvergenceError, InstabilityError, bad_input
from flatland.kernels import Sweep
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.reports import Buffer
from flatland.solvers.choice import METHODS, candidates
from flatland.solvers.growth import growth_factor, may_grow
from flatland.solvers.methods import prepare, run
from flatland.solvers.problem import Problem
from flatland.stability import RADIUS_TOLERANCE
from flatland.stencil import Stencil
from flatland.symmetry import is_mirror_symmetric


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


def solve_converged(
    sweep: Sweep, right: Buffer, answer: Buffer, tolerance: float, method: str = "auto"
) -> SolveReport:
    """Write the solution of (1 − A) S_A = S_0 into `answer`.

    tolerance: bound on the relative residual. method: "multigrid" (BiCGSTAB with a multigrid
    cycle as preconditioner; van der Vorst 1992), "aggregation" (GCR with multigrid over groups of
    cells that end at walls; see `Aggregation`), "mirrored" (fast transforms, and GMRES at the
    border and on walls alone; see `Reduced`), "stepping", "krylov" (BiCGSTAB alone),
    "factorization" (sparse LU, kept for further lights), or "auto": kept factors if there are any,
    multigrid for schemes that diffuse in open 2D grids with few bands, groups among walls in 3D,
    groups or BiCGSTAB where walls are everywhere in 2D, else transforms in grids that are worth
    their set-up, and others in turn where one stalls. Works in float64 whatever the fields'
    precision, and goes on from the last answer where the light is nearly the same.

    Raises InstabilityError if the spectral radius exceeds 1, of the scheme or of what reflecting
    walls make of it (the sum over steps then has no limit), ConvergenceError if the tolerance is
    not reached.
    """
    if method not in METHODS:
        raise bad_input("method", method, "is unknown", METHODS)
    if method == "mirrored" and not is_mirror_symmetric(sweep.stencil):
        rule = "needs a scheme that is its own mirror image"
        raise bad_input("method", method, rule, ("auto", "multigrid", "krylov"))
    require_solvable(sweep.stencil, tolerance)
    problem = Problem(sweep, right)
    names = candidates(problem.sweep, method)
    prepare(problem, names[0])
    begin = time.perf_counter()
    problem.start_from_last()
    for name in names:
        values = run(problem, name, tolerance)
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
    suspicious = not sums and not (solved and not may_grow(problem.sweep, values))
    if suspicious and not problem.sweep.tame:
        require_no_growth(problem.sweep, problem.light)
        # Other lights that get to the same cells go through the same operator.
        problem.sweep.tame = True
    require_solved(report)
    problem.keep(values)
    return report


def require_solvable(stencil: Stencil, tolerance: float) -> None:
    """Raise InputError for a tolerance that is none, InstabilityError where no answer exists."""
    if not 0 < tolerance < 1:
        raise bad_input("tolerance", tolerance, "must lie between 0 and 1")
    radius = stencil.spectral_radius()
    if radius > 1 + RADIUS_TOLERANCE:
        message = f"no converged field: the scheme's spectral radius is {radius:.4f}, above 1"
        raise InstabilityError(message)


def require_solved(report: SolveReport) -> None:
    """Raise ConvergenceError where the tolerance was not reached."""
    if not report.residual <= report.tolerance:
        message = (
            f"{report.method} stopped at a relative residual of {report.residual:.2e}, not "
            f"{report.tolerance:.2e}, after {report.iterations} iterations; the field reached so "
            "far is kept"
        )
        raise ConvergenceError(message)


def require_no_growth(sweep: AnySweep, light: Buffer) -> None:
    """Raise InstabilityError where walls send back more than they get."""
    if sweep.reflection is None:
        return
    growth = growth_factor(sweep, light)
    if growth > 1:
        message = (
            f"no converged field: light grows by a factor {growth:.4f} a step among these walls, "
            "though the scheme is stable without them"
        )
        raise InstabilityError(message)
