"""Benchmarks print ratios to limits taken in the same run, so that a noisy machine cancels out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))


def median_seconds(call: Callable[[], object], repeats: int) -> float:
    """Median time of one call, after one that is not counted."""
    call()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return float(np.median(times))


@pytest.fixture(scope="session")
def report() -> Callable[[str], None]:
    """Print a line of results, whatever pytest captures."""

    def show(line: str) -> None:
        sys.__stdout__.write(line + "\n")
        sys.__stdout__.flush()

    return show
