"""A process of its own for answers that cannot be interrupted: it is ended when nobody wants them.

It is kept for the next question, since starting one takes a second.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from flatland.errors import FlatlandError

#: Seconds between two looks at whether the answer is still wanted.
_POLL = 0.02

_idle: list[_Helper] = []
_lock = threading.Lock()


class HelperError(Exception):
    """Something in the helper broke; `details` tell where."""

    def __init__(self, text: str, details: str) -> None:
        super().__init__(text)
        self.details = details


class _Helper:
    """One process and the pipe to it."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        self.process.start()
        other.close()

    def ask(
        self,
        task: Callable[..., Any],
        arguments: tuple[Any, ...],
        wanted: Callable[[], bool],
        tell: Callable[[str], object],
    ) -> tuple[str, Any]:
        self.pipe.send((task, arguments))
        while True:
            while not self.pipe.poll(_POLL):
                if not wanted():
                    return "unwanted", None
            kind, value = self.pipe.recv()
            if kind != "warning":
                return kind, value
            tell(value)

    def end(self) -> None:
        self.process.kill()
        self.process.join(2)
        self.pipe.close()


def ask(
    task: Callable[..., Any],
    *arguments: Any,
    wanted: Callable[[], bool],
    tell: Callable[[str], object] = lambda text: None,
) -> Any:
    """task(*arguments), computed elsewhere; None as soon as it is no longer wanted.

    task: a function of a module. tell: hears its warnings. Raises the project's own errors as they
    are, HelperError for all others.
    """
    with _lock:
        helper = _idle.pop() if _idle else None
    if helper is None or not helper.process.is_alive():
        helper = _Helper()
    kind, value = "broken", ("the helper process ended", "")
    try:
        kind, value = helper.ask(task, arguments, wanted, tell)
    except (EOFError, OSError) as error:
        value = (f"the helper process ended: {error!r}", "")
    finally:
        if kind in ("answer", "refused", "fault"):
            with _lock:
                _idle.append(helper)
        else:
            helper.end()
    if isinstance(value, FlatlandError):
        raise value
    if kind in ("fault", "broken"):
        raise HelperError(*value)
    return value


def _serve(pipe: Connection) -> None:
    """Answer until the other end is gone."""
    import warnings

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("always")
    warnings.showwarning = lambda message, *_, **__: pipe.send(("warning", str(message)))
    while True:
        try:
            task, arguments = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer: tuple[str, Any] = ("answer", task(*arguments))
        except FlatlandError as error:
            answer = ("refused", error)
        except Exception as error:  # noqa: BLE001 - told on the other side
            answer = ("fault", (f"{type(error).__name__}: {error}", traceback.format_exc()))
        pipe.send(answer)
