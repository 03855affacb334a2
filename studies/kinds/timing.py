"""Times that can be trusted: a run that is not counted, repeats, median and spread."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Timing:
    """Seconds of a run: median and quartiles of `repeats` runs, and of the first one.

    The first run also compiles and fills caches; it is no part of the others. repeats is 0 for a
    single run that may have had others beside it.
    """

    median: float
    low: float
    high: float
    repeats: int
    first: float

    @classmethod
    def of(cls, seconds: Sequence[float], first: float | None = None) -> Timing:
        """first: of the run before them; None if `seconds` is the only run there was."""
        low, median, high = np.percentile(seconds, [25, 50, 75])
        repeats = 0 if first is None else len(seconds)
        return cls(
            float(median), float(low), float(high), repeats, seconds[0] if first is None else first
        )

    def as_row(self) -> dict[str, Any]:
        return {
            "seconds": self.median,
            "seconds_low": self.low,
            "seconds_high": self.high,
            "repeats": self.repeats,
            "first_seconds": self.first,
        }


@dataclass(frozen=True)
class Stopwatch:
    """Times a call `repeats` times after one that is not counted; 0: once, and that counts."""

    repeats: int

    def measure(self, call: Callable[[], Answer]) -> tuple[Answer, Timing]:
        """The last answer and the times."""
        seconds = []
        for _ in range(self.repeats + 1):
            begin = time.perf_counter()
            answer = call()
            seconds.append(time.perf_counter() - begin)
        return answer, Timing.of(seconds[1:], seconds[0]) if self.repeats else Timing.of(seconds)
