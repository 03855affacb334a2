"""Passes over long vectors on a device, each doing all that one read of memory allows.

As `flatland.solvers.vectors` on the host; all in double precision.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flatland.cuda.parts import (
    BLOCKS,
    LARGEST_BLOCK,
    blocks_for,
    each,
    gather,
    kernel,
    preamble,
    summing,
    threads,
)

if TYPE_CHECKING:
    from flatland.cuda.device import CudaDevice

_REPORT = ["long long row", "double* __restrict__ partial"]


class Vectors:
    """Kernels of `vector_text` and their calls, for vectors (size,) on a device."""

    def __init__(self, device: CudaDevice, kernels: dict[str, Any]) -> None:
        self._kernels = kernels
        self._partial = device.zeros(2 * BLOCKS, np.float64)
        self._sums = device.zeros(2, np.float64)

    def two_dots(self, a: Any, b: Any, c: Any) -> tuple[float, float]:
        """a·b and c·c."""
        return self._summed("two_dots", a, b, c)

    def subtract(self, r: Any, factor: float, v: Any, shadow: Any) -> tuple[float, float]:
        """r −= factor v; gives r·r and shadow·r."""
        return self._summed("subtract", r, np.float64(factor), v, shadow)

    def add(self, x: Any, alpha: float, p: Any, omega: float, s: Any) -> None:
        """x += alpha p + omega s."""
        self._call("add", x, np.float64(alpha), p, np.float64(omega), s)

    def direction(self, p: Any, r: Any, beta: float, omega: float, v: Any) -> None:
        """p = r + beta (p − omega v)."""
        self._call("direction", p, r, np.float64(beta), np.float64(omega), v)

    def copy(self, source: Any, target: Any) -> None:
        """target = source."""
        self._call("copy", source, target)

    def _call(self, name: str, first: Any, *others: Any) -> None:
        grid = (blocks_for(first.size, LARGEST_BLOCK),)
        size = np.int64(first.size)
        self._kernels[name](grid, (LARGEST_BLOCK,), (first, *others, size))

    def _summed(self, name: str, first: Any, *others: Any) -> tuple[float, float]:
        self._partial.fill(0)
        grid = (blocks_for(first.size, LARGEST_BLOCK),)
        arguments = (first, *others, np.int64(first.size), np.int64(0), self._partial)
        self._kernels[name](grid, (LARGEST_BLOCK,), arguments)
        found = gathered(self._kernels["gather"], self._partial, self._sums, 2)
        return float(found[0]), float(found[1])


def gathered(gather: Any, partial: Any, sums: Any, count: int) -> NDArray[np.float64]:
    """The first sums of what blocks have left in `partial`, on the host."""
    gather((count,), (LARGEST_BLOCK,), (partial, sums))
    return np.asarray(sums.get()[:count])


def vector_text() -> str:
    """CUDA C of all passes."""
    lines = [preamble(np.dtype(np.float64), 0), *gather()]
    for name, (arguments, body) in _PASSES.items():
        lines += _pass(name, arguments, body)
    return "\n".join(lines)


def _pass(name: str, arguments: list[str], body: list[str]) -> list[str]:
    """A kernel over all numbers of a vector; its sums, if any, are `first` and `second`."""
    loop = each("i", "size", LARGEST_BLOCK, body)
    if not any("first" in line for line in body):
        return kernel(name, [*arguments, "long long size"], threads(LARGEST_BLOCK, loop))
    summed = summing(["first", "second"], LARGEST_BLOCK, loop)
    return kernel(name, [*arguments, "long long size", *_REPORT], summed)


#: Arguments of each, and what it does with number i.
_PASSES: dict[str, tuple[list[str], list[str]]] = {
    "two_dots": (
        # Two of them may be the same vector, and all are only read.
        ["const double* a", "const double* b", "const double* c"],
        ["first = fma(a[i], b[i], first);", "second = fma(c[i], c[i], second);"],
    ),
    "subtract": (
        ["double* r", "double factor", "const double* v", "const double* shadow"],
        [
            "const double value = fma(-factor, v[i], r[i]);",
            "r[i] = value;",
            "first = fma(value, value, first);",
            "second = fma(shadow[i], value, second);",
        ],
    ),
    "add": (
        ["double* x", "double alpha", "const double* p", "double omega", "const double* s"],
        ["x[i] += alpha * p[i] + omega * s[i];"],
    ),
    "direction": (
        ["double* p", "const double* r", "double beta", "double omega", "const double* v"],
        ["p[i] = r[i] + beta * (p[i] - omega * v[i]);"],
    ),
    "copy": (
        ["const double* source", "double* target"],
        ["target[i] = source[i];"],
    ),
}

#: Kernels of `vector_text`.
VECTOR_KERNELS = ("gather", *_PASSES)
