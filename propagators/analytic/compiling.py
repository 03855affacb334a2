"""How the kernels of this package are compiled and shared among cores."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

from flatland.kernels.threads import run_shared, thread_count

#: For functions that only other kernels call: the wrappers for Python would cost a fifth of the
#: compile time. The cache is keyed by each function's own file: after editing a callee in another
#: file, clear propagators/analytic/__pycache__.
inner = njit(cache=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
#: The same, copied into their callers: for small ones in hot loops, where handing over a dozen
#: arrays costs more than the work.
inlined = njit(
    cache=True,
    error_model="numpy",
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
    forceinline=True,
)
#: For functions that Python calls, perhaps in several threads at once. Numba's own threads would
#: take two seconds longer to compile, and be a second pool beside the one of the stencils.
shared = njit(cache=True, error_model="numpy", nogil=True)

#: Waking another thread costs as much as about this many targets.
_FEW = 64


def parties_for(count: int) -> int:
    """In how many threads to share `count` pieces of work."""
    return thread_count() if count > _FEW else 1


def share_work(kernel: Callable[..., None], count: int, *arguments: Any) -> None:
    """Call kernel(party, parties, *arguments) in the threads that `count` pieces of work are worth.

    A kernel does the pieces party, party + parties, …, and writes into one of its arguments.
    """

    def run(party: int, parties: int) -> None:
        kernel(party, parties, *arguments)

    run_shared(run, parties_for(count))
