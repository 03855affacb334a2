"""What a sweep is measured against: the memory traffic alone, and plain NumPy."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels import Layout
from flatland.kernels.threads import rows_of, thread_count
from flatland.stencil import Stencil

Buffer = NDArray[np.floating]
#: Passes in a row per call, so that handing work to threads does not count.
_PASSES = 16
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


def traffic_seconds(layout: Layout, repeats: int = 30) -> float:
    """Time of reading source, writing target and updating total once, with no arithmetic.

    Same arrays, same threads as the sweep: where they fit into the cache, so does this limit.
    """
    source, target, total = (layout.allocate() for _ in range(3))
    parts = [rows_of(p, thread_count(), source.size) for p in range(thread_count())]
    with ThreadPoolExecutor(len(parts)) as pool:

        def call() -> None:
            list(
                pool.map(
                    lambda ab: _traffic(*(x[slice(*ab)] for x in (source, target, total)), _PASSES),
                    parts,
                )
            )

        return best_seconds(call, repeats) / _PASSES


def main_memory_bandwidth() -> float:
    """Bytes per second of the same traffic on arrays that no cache holds."""
    layout = Layout((LARGE, LARGE), 1, np.dtype(np.float32))
    return 4 * 4 * LARGE**2 / traffic_seconds(layout, 3)


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
