"""Warnings of the engine as notices, whichever thread they come from."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

_lock = threading.Lock()
_ears: dict[int, Callable[[str], object]] = {}
_outer: list[warnings.catch_warnings[None]] = []


@contextmanager
def listening(tell: Callable[[str], object]) -> Iterator[None]:
    """Inside, warnings of this thread are told, every time, and shown nowhere else.

    Python keeps its warning filters once for all threads: the first thread that listens changes
    them and the last one puts them back. Meanwhile warnings of other threads are dropped.
    """
    me = threading.get_ident()
    with _lock:
        before = _ears.get(me)
        _ears[me] = tell
        if not _outer:
            _outer.append(warnings.catch_warnings())
            _outer[0].__enter__()
            warnings.simplefilter("always")
            warnings.showwarning = _show
    try:
        yield
    finally:
        with _lock:
            if before is None:
                del _ears[me]
            else:
                _ears[me] = before
            if not _ears:
                _outer.pop().__exit__(None, None, None)


def _show(message: Any, *_: Any, **__: Any) -> None:
    tell = _ears.get(threading.get_ident())
    if tell is not None:
        tell(str(message))
