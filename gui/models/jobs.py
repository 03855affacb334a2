"""What is asked of workers, and who hears of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from flatland.scene import Scene
from gui.models.choice import Choice
from gui.models.frame import Frame
from gui.models.track import Row


class Cancelled(Exception):  # noqa: N818 - not an error
    """The user wanted no more of this."""


class Watch(Protocol):
    """Who is told what a job does."""

    def cancelled(self) -> bool: ...

    def sleep(self, seconds: float) -> None: ...

    def publish(self, frame: Frame, rows: list[Row]) -> None: ...

    def progress(self, done: int, total: int) -> None: ...

    def notice(self, text: str) -> None: ...


@dataclass(frozen=True)
class Job:
    """A wish: what to do, for which scene and method.

    stamp: number of the scene and method; results of an older one are dropped.
    """

    kind: str
    scene: Scene
    choice: Choice
    stamp: int = 0
    arguments: Mapping[str, Any] = field(default_factory=dict)


class Runner(Protocol):
    """Who does jobs, elsewhere, and calls the session back on its own thread."""

    def submit(self, job: Job) -> None: ...

    def cancel(self) -> None: ...

    @property
    def waiting(self) -> int: ...
