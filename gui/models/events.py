"""Observers: who wants to know that a model changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Event:
    """A list of callbacks, called in the order in which they joined.

    Callbacks run in the caller's thread; models are changed on the GUI's thread alone.
    """

    def __init__(self) -> None:
        self._callbacks: list[Callable[..., object]] = []

    def connect(self, callback: Callable[..., object]) -> None:
        self._callbacks.append(callback)

    def disconnect(self, callback: Callable[..., object]) -> None:
        if callback in self._callbacks:
            self._callbacks.remove(callback)

    def emit(self, *arguments: Any) -> None:
        for callback in list(self._callbacks):
            callback(*arguments)
