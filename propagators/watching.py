"""Who wants to know how far an answer that takes long has come."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

#: Called now and then with the share of the work that is done, from 0 to 1.
Progress = Callable[[float], object]

_watcher: ContextVar[Progress | None] = ContextVar("answer_watcher", default=None)


@contextmanager
def watched(watcher: Progress) -> Iterator[None]:
    """Inside, and in this thread, answers that may take seconds call `watcher` with the share done.

    Each answer begins anew at 0. What the watcher raises stops the answer.
    """
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def watcher() -> Progress:
    """Whoever watches; without any, a function that does nothing."""
    return _watcher.get() or nobody


def nobody(share: float) -> None:
    """Nobody watches."""
