"""How many threads, and running one call in each."""

from __future__ import annotations

import ctypes
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

from numpy.typing import NDArray

from flatland.errors import bad_input

#: Only one batch at a time may own the helpers; a second one runs on its own thread alone.
_helpers_free = threading.Lock()


def thread_count() -> int:
    """Threads for one sweep: FLATLAND_THREADS if set, else the processors this process may use."""
    wanted = os.environ.get("FLATLAND_THREADS")
    if wanted is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else (os.cpu_count() or 1)
    if not wanted.isdecimal() or int(wanted) < 1:
        raise bad_input("FLATLAND_THREADS", wanted, "must be a whole number, at least 1")
    return int(wanted)


def run_shared(call: Callable[[int, int], None], parties: int) -> None:
    """Run call(party, parties) for every party at once, each in a thread.

    The parties may wait for one another, so all of them must be running: when another thread of
    this process owns the helpers, everything is done as one party instead.
    """
    if parties == 1 or not _helpers_free.acquire(blocking=False):
        call(0, 1)
        return
    try:
        futures = [
            _helpers(os.getpid(), parties).submit(call, p, parties) for p in range(1, parties)
        ]
        call(0, parties)
        for future in futures:
            future.result()
    finally:
        _helpers_free.release()


def rows_of(party: int, parties: int, rows: int) -> tuple[int, int]:
    """First and last (excluded) of `rows` for one of `parties`."""
    return party * rows // parties, (party + 1) * rows // parties


@cache
def yield_address() -> int:
    """Address of the system's function that gives up the processor for a moment."""
    if os.name == "nt":
        function = ctypes.windll.kernel32.SwitchToThread  # type: ignore[attr-defined]
    else:
        function = ctypes.CDLL(None).sched_yield
    return ctypes.cast(function, ctypes.c_void_p).value or 0


@cache
def _helpers(process: int, parties: int) -> ThreadPoolExecutor:
    """The helper threads of a process (a forked child needs its own).

    One pool per number of parties: in a pool with fewer threads, parties would wait for ever for
    one that cannot start.
    """
    return ThreadPoolExecutor(max_workers=parties - 1, thread_name_prefix="sweep")


def address(buffer: NDArray[Any] | None) -> int:
    """Memory address of an array, 0 for None."""
    return 0 if buffer is None else int(buffer.__array_interface__["data"][0])
