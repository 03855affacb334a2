"""Looking on while a solver works, and stopping it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_watcher: ContextVar[Callable[[int], object] | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(watcher: Callable[[int], object]) -> Iterator[None]:
    """Inside, and in this thread, every solver calls `watcher` with the number of applications of
    its operator that it has just done. What the watcher raises stops the solver."""
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def applied(count: int) -> None:
    """Tell whoever watches."""
    watcher = _watcher.get()
    if watcher is not None:
        watcher(count)
