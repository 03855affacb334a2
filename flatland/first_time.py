"""Kernels are compiled once, when they are first needed: tells those who would wonder why it takes.

What is compiled is kept beside the package, so that a second start does not wait.
"""

from __future__ import annotations

from collections.abc import Callable

#: What a user is told.
NOTICE = "compiling for the first time, a few seconds; it is kept for the next start"

_waiting: list[Callable[[], object]] = []


def when_compiling(call: Callable[[], object]) -> None:
    """Call this once when the next kernel is compiled, from the thread that needs it."""
    _waiting.append(call)


def listen() -> None:
    """Hear of what Numba compiles. Loading from its cache does not count."""
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event: object) -> None:
            calls, _waiting[:] = list(_waiting), []
            for call in calls:
                call()

        def on_end(self, event: object) -> None:
            pass

    event.register("numba:compile", Listener())
