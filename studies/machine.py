"""The machine that numbers were taken on, and how much memory they took."""

from __future__ import annotations

import os
import platform
from functools import cache
from pathlib import Path
from typing import Any

from flatland.kernels.threads import thread_count


@cache
def _hardware() -> dict[str, Any]:
    return {
        "processor": _processor(),
        "processors": len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count() or 1,
        "system": platform.system(),
        "architecture": platform.machine(),
        "python": platform.python_version(),
    }


def describe_machine() -> dict[str, Any]:
    """Processor, number of processors this process may use, system, Python, threads of a sweep."""
    return {**_hardware(), "threads": thread_count()}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


class MemoryMeter:
    """By how much this process grew at its highest since the meter was made, in bytes.

    On Linux the high-water mark is set back at the start; elsewhere nothing is known, -1. What the
    process had freed before and takes again does not count.
    """

    def __init__(self) -> None:
        try:
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
            self._start: int | None = _status("VmRSS")
        except (OSError, ValueError, KeyError):
            self._start = None

    def peak(self) -> int:
        return -1 if self._start is None else max(0, _status("VmHWM") - self._start)


def _status(name: str) -> int:
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    rows = dict(line.split(":", 1) for line in lines if ":" in line)
    return int(rows[name].split()[0]) * 1024
