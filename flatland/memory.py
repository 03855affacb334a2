"""Refuse what would not fit, before it is allocated."""

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


def gigabytes(count: int) -> str:
    return f"{count / 2**30:,.2f} GiB"


def _linux_available() -> int:
    with open("/proc/meminfo", encoding="ascii") as file:  # noqa: PTH123
        rows = dict(line.split(":", 1) for line in file)
    return int(rows["MemAvailable"].split()[0]) * 1024
