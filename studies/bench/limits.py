"""What a sweep is measured against: memory traffic alone, arithmetic alone, and plain NumPy."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, reduce

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels import Layout
from flatland.kernels.compiler import compile_text
from flatland.kernels.threads import rows_of, run_shared, thread_count
from flatland.kernels.writer import Writer
from flatland.stencil import Stencil

Buffer = NDArray[np.floating]
#: Passes in a row per call, so that handing work to threads does not count.
_PASSES = 16
#: Chains of multiply-adds that do not wait for one another, and links of each.
_CHAINS, _ROUNDS = 16, 100_000
#: Numbers along each side of arrays that no cache holds.
LARGE = 4096


def best_seconds(call: Callable[[], object], repeats: int) -> float:
    """Shortest time of one call, after one that is not counted.

    The shortest, because on a shared machine everything longer is somebody else's work.
    """
    call()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


@njit(nogil=True, fastmath=True, cache=True)
def _traffic(source, target, total, passes):  # type: ignore[no-untyped-def]
    for _ in range(passes):
        for i in range(source.size):
            target[i] = source[i]
            total[i] += source[i]


class Traffic:
    """Reading source, writing target and updating total once, with no arithmetic.

    Same arrays, same threads as the sweep: where they fit into the cache, so does this limit.
    """

    def __init__(self, layout: Layout) -> None:
        self._fields = [layout.allocate() for _ in range(3)]
        self._parts = [rows_of(p, thread_count(), layout.size) for p in range(thread_count())]
        self._pool = ThreadPoolExecutor(len(self._parts))

    def __call__(self) -> None:
        list(self._pool.map(self._part, self._parts))

    def _part(self, numbers: tuple[int, int]) -> None:
        _traffic(*(field[slice(*numbers)] for field in self._fields), _PASSES)

    def seconds(self, repeats: int) -> float:
        """Of one pass."""
        return best_seconds(self, repeats) / _PASSES


@cache
def main_memory_bandwidth() -> float:
    """Bytes per second of the same traffic on arrays that no cache holds."""
    traffic = Traffic(Layout((LARGE, LARGE), 1, np.dtype(np.float32)))
    return 4 * 4 * LARGE**2 / traffic.seconds(6)


@cache
def multiply_add_rate(precision: str) -> float:
    """Multiply-adds per second of all threads: vectors in registers, none waiting for another."""
    writer = Writer(Layout((1, 1), 1, np.dtype(precision)))
    kind, chains = writer.vector, range(_CHAINS)
    writer.declarations()
    writer.put("define void @multiply(ptr %S, i64 %count) {\nentry:")
    factor = writer.load("%S", "0", 0)
    writer.put("  br label %again\nagain:\n  %i = phi i64 [0, %entry], [%next, %again]")
    for c in chains:
        writer.put(f"  %old{c} = phi {kind} [{factor}, %entry], [%new{c}, %again]")
    for c in chains:
        of = f"{kind} %old{c}, {kind} {factor}, {kind} {factor}"
        writer.put(f"  %new{c} = call {kind} @llvm.fma.{writer.suffix}({of})")
    writer.put("  %next = add i64 %i, 1\n  %more = icmp slt i64 %next, %count")
    writer.put("  br i1 %more, label %again, label %end\nend:")
    total = reduce(lambda a, b: writer.binary("fadd", a, b), [f"%new{c}" for c in chains])
    writer.store("%S", "0", 0, total)
    writer.put("  ret void\n}")
    code = compile_text("\n".join(writer.lines))
    multiply, parties = code.function("multiply"), thread_count()
    values = np.full((parties, 2 * writer.layout.lanes), 0.5, precision)
    seconds = best_seconds(
        lambda: run_shared(lambda p, _: multiply(values[p].ctypes.data, _ROUNDS), parties), 200
    )
    return _CHAINS * _ROUNDS * writer.layout.lanes * parties / seconds


def numpy_step(stencil: Stencil, source: Buffer, target: Buffer, total: Buffer) -> None:
    """One iteration as one would first write it: matrix products and shifted additions."""
    target[...] = 0
    nx, ny = source.shape[1:]
    for (dx, dy), transfer in zip(stencil.offsets, stencil.transfer):
        moved = np.tensordot(transfer.astype(source.dtype), source, 1)
        to = (slice(max(0, dx), nx + min(0, dx)), slice(max(0, dy), ny + min(0, dy)))
        come = (slice(max(0, -dx), nx + min(0, -dx)), slice(max(0, -dy), ny + min(0, -dy)))
        target[(slice(None), *to)] += moved[(slice(None), *come)]
    total += target
