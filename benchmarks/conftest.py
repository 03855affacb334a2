"""Benchmarks print ratios to limits taken in the same run, so that a noisy machine cancels out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


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


@pytest.fixture(scope="session")
def report() -> Callable[[str], None]:
    """Print a line of results, whatever pytest captures."""

    def show(line: str) -> None:
        sys.__stdout__.write(line + "\n")
        sys.__stdout__.flush()

    return show
