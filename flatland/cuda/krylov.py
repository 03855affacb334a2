"""BiCGSTAB on a device (van der Vorst 1992), without a preconditioner.

As `flatland.solvers.bicgstab`; what it needs of a vector is on the device, and of it only inner
products come back.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from flatland.cuda.device import CudaDevice, DeviceArray

Operator = Callable[[DeviceArray, DeviceArray], None]


def bicgstab(
    device: CudaDevice, apply: Operator, right: DeviceArray, tolerance: float, limit: int
) -> tuple[DeviceArray, int]:
    """Iterate on apply(x) = right from zero until the relative residual is below the tolerance.

    apply writes into its second vector. Gives the answer and the number of iterations. Ends early
    when the recurrence breaks down or the residual grows by 10^4; the caller checks the true one.
    """
    vectors = device.vectors
    answer, r, p, v, t = (device.zeros(right.size, np.float64) for _ in range(5))
    vectors.copy(right, r)
    vectors.copy(right, p)
    rho = start = vectors.two_dots(right, right, right)[0]
    goal, iterations = tolerance**2 * start, 0
    while start > 0 and iterations < limit:
        iterations += 1
        apply(p, v)
        curvature = vectors.two_dots(right, v, v)[0]
        if curvature == 0 or not math.isfinite(curvature):
            break
        alpha = rho / curvature
        squares, _ = vectors.subtract(r, alpha, v, right)  # r is now s
        if squares <= goal:
            vectors.add(answer, alpha, p, 0.0, p)
            break
        apply(r, t)
        product, length = vectors.two_dots(t, r, t)
        if length == 0 or not math.isfinite(length):
            break
        omega = product / length
        vectors.add(answer, alpha, p, omega, r)
        squares, new_rho = vectors.subtract(r, omega, t, right)
        if squares <= goal or omega == 0 or rho == 0 or squares > 1e8 * start:
            break
        vectors.direction(p, r, new_rho / rho * alpha / omega, omega, v)
        rho = new_rho
    return answer, iterations
