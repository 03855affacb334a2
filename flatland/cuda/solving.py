"""The converged field of a linear scheme, found on a device."""

from __future__ import annotations

import math
import time

import numpy as np

from flatland.cuda.device import DeviceArray
from flatland.cuda.krylov import bicgstab
from flatland.cuda.sweep import CudaSweep
from flatland.errors import bad_input
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.reports import Buffer
from flatland.solvers.converged import (
    SolveReport,
    require_no_growth,
    require_solvable,
    require_solved,
)
from flatland.solvers.growth import may_grow
from flatland.solvers.lighted import lighted_cells, reflection_in
from flatland.solvers.watching import applied

#: Of `flatland.solvers.METHODS`, those that need nothing but the operator itself.
METHODS = ("auto", "krylov", "stepping")
_ITERATIONS = 4000
_STEPS, _BATCH = 20_000, 16


def solve_on_device(
    sweep: AnySweep, right: Buffer, answer: Buffer, tolerance: float, method: str = "auto"
) -> SolveReport:
    """Write the solution of (1 − A) S_A = S_0 into `answer`; see `solve_converged`.

    right, answer: on the host, as `sweep` steps them. method: "krylov" (BiCGSTAB alone),
    "stepping", or "auto": both in turn. In float64 whatever the fields' precision. What it gets
    wrong: without a preconditioner, iterations grow with the length of the grid.
    """
    assert isinstance(sweep, CudaSweep)
    if method not in METHODS:
        raise bad_input("method", method, 'is unknown on device "cuda"', METHODS)
    require_solvable(sweep.stencil, tolerance)
    problem = _Problem(sweep, right)
    begin = time.perf_counter()
    for name in METHODS[1:] if method == "auto" else (method,):
        found = problem.by_krylov(tolerance) if name == "krylov" else problem.by_steps(tolerance)
        values, residual = problem.finished(found)
        if residual <= tolerance:
            break
    sweep.layout.view(answer)[...] = problem.sweep.layout.view(values)
    seconds = time.perf_counter() - begin
    report = SolveReport(
        name, problem.iterations, problem.applications, residual, tolerance, seconds
    )
    solved = residual <= tolerance
    sums = solved and name == "stepping"
    if not sums and not (solved and not may_grow(problem.sweep, values)):
        require_no_growth(problem.sweep, problem.light)
    require_solved(report)
    return report


class _Problem:
    """(1 − A) x = b on padded float64 fields on the device; the border of zeros stays zero."""

    def __init__(self, sweep: CudaSweep, right: Buffer) -> None:
        self.device = sweep.device
        key = reflection = self._dark = None
        if sweep.reflection is not None:
            lighted = lighted_cells(sweep, right)
            key, self._dark = lighted.tobytes(), ~lighted
            reflection = reflection_in(sweep.reflection, lighted)
        self.sweep = sweep.in_double(key, reflection).prepared_to_solve()
        layout = self.sweep.layout
        self.light = layout.allocate()
        layout.view(self.light)[...] = sweep.layout.view(right)
        self._right = self.device.upload(self.light)
        self._size = self._length(self._right)
        self.applications = self.iterations = 0

    def by_krylov(self, tolerance: float) -> DeviceArray:
        found, iterations = bicgstab(
            self.device, self._apply, self._right, 0.5 * tolerance, _ITERATIONS
        )
        self.iterations += iterations
        return found

    def by_steps(self, tolerance: float) -> DeviceArray:
        """The sum over steps itself."""
        source, total, target = (self._zeros() for _ in range(3))
        for vector in (source, total):
            self.device.vectors.copy(self._right, vector)
        for _ in range(_STEPS // _BATCH):
            sums = self.sweep.run(source, target, total, _BATCH)
            self.iterations += _BATCH
            self._count(_BATCH)
            if not sums.squares[-1] > (0.5 * tolerance * self._size) ** 2:
                break
        return total

    def finished(self, found: DeviceArray) -> tuple[Buffer, float]:
        """An answer on the host, dark where no light gets to, and its relative residual."""
        values = self.sweep.layout.allocate()
        found.get(out=values)
        if self._dark is not None:
            self.sweep.layout.view(values)[:, self._dark] = 0.0
            found.set(values)
        defect = self._zeros()
        self.sweep.apply((-1.0, 1.0, 1.0), found, self._right, defect)
        return values, self._length(defect) / self._size if self._size else 0.0

    def _apply(self, values: DeviceArray, result: DeviceArray) -> None:
        """(1 − A) x."""
        self._count(1)
        self.sweep.apply((1.0, 0.0, -1.0), values, values, result)

    def _count(self, applications: int) -> None:
        self.applications += applications
        applied(applications)

    def _zeros(self) -> DeviceArray:
        return self.device.zeros(self.sweep.layout.size, np.float64)

    def _length(self, vector: DeviceArray) -> float:
        return math.sqrt(self.device.vectors.two_dots(vector, vector, vector)[0])
