"""Refuse what would not fit, before it is allocated; and tell what a run took."""

from __future__ import annotations

import os

from flatland.errors import bad_input


def available_memory() -> int:
    """Bytes of memory that this machine could still hand out."""
    try:
        return _linux_available()
    except (OSError, ValueError, KeyError):
        try:
            return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        except (AttributeError, OSError, ValueError):
            return 2**62  # unknown: nothing is refused


def require_memory(needed: int, argument: str, value: object) -> None:
    """Raise InputError if `needed` bytes exceed what is available; say both amounts."""
    available = available_memory()
    if needed > available:
        rule = f"needs {gigabytes(needed)} of memory, this machine has {gigabytes(available)} free"
        raise bad_input(argument, value, rule)


class PeakMemory:
    """Memory that this process takes from now on beyond what it has, at the peak.

    Counts pages that are really in use. `taken` is None where the system does not tell (it is read
    from Linux' /proc).
    """

    def __init__(self) -> None:
        self._before: int | None = None
        try:
            with open("/proc/self/clear_refs", "w", encoding="ascii") as file:  # noqa: PTH123
                file.write("5")  # the peak begins anew
            self._before = _status("VmRSS")
        except (OSError, ValueError, KeyError):
            return

    @property
    def taken(self) -> int | None:
        """Bytes, so far."""
        return None if self._before is None else max(0, _status("VmHWM") - self._before)


def megabytes(count: int) -> str:
    return f"{count / 2**20:,.1f} MiB"


def gigabytes(count: int) -> str:
    return f"{count / 2**30:,.2f} GiB"


def _linux_available() -> int:
    return _entry("/proc/meminfo", "MemAvailable")


def _status(name: str) -> int:
    return _entry("/proc/self/status", name)


def _entry(path: str, name: str) -> int:
    """Bytes, from one of Linux' tables in kB."""
    with open(path, encoding="utf-8") as file:  # noqa: PTH123
        rows = dict(line.split(":", 1) for line in file)
    return int(rows[name].split()[0]) * 1024
