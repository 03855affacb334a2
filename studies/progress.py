"""Progress bars on a terminal, nothing in a pipe."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from propagators.watching import watched

if TYPE_CHECKING:
    from studies.sweeps.case import Case
    from studies.sweeps.store import Record


#: Seconds that work may take before a bar shows it.
_PATIENCE = 1.0


@contextmanager
def steps_bar(total: int, wanted: bool = True) -> Iterator[Callable[[int], object] | None]:
    """A bar on stderr; gives the function to call with the number of steps just done.

    Exact answers that take long have a bar of their own, beside it or, without one, alone.
    """
    if not sys.stderr.isatty():
        yield None
        return
    with _bars() as bars, watched(_Shares(bars)):
        if not wanted:
            yield None
            return
        task = bars.add_task("steps", total=total)
        yield lambda count: bars.advance(task, count)


@contextmanager
def answer_bar() -> Iterator[None]:
    """A bar on stderr for exact answers that take long."""
    with steps_bar(0, wanted=False):
        yield


def _bars() -> Any:
    """Bars that come up when the work has taken a while, and go when it is done."""
    from rich.console import Console, RenderableType
    from rich.progress import Progress

    begin = time.monotonic()

    class Late(Progress):
        def get_renderables(self) -> Iterator[RenderableType]:
            if time.monotonic() - begin > _PATIENCE:
                yield from super().get_renderables()

    return Late(console=Console(stderr=True), transient=True)


class _Shares:
    """Shows shares of exact answers, one after the other."""

    def __init__(self, bars: Any) -> None:
        self._bars, self._task = bars, None

    def __call__(self, share: float) -> None:
        if self._task is None:
            self._task = self._bars.add_task("exact answer", total=1.0)
        self._bars.update(self._task, completed=share, visible=share < 1)


class StudyProgress:
    """Shows the cases of a study as a bar if there is one, and says what is worth knowing."""

    def __init__(self, bar: Any = None) -> None:
        self._bar, self._task = bar, None
        self._failed = 0

    def begin(self, total: int, kept: int) -> None:
        if self._bar is not None:
            self._task = self._bar.add_task("", total=total, failed=0)

    def stage(self, name: str) -> None:
        self._update(description=name)

    def finished(self, case: Case, record: Record) -> None:
        self._failed += record.status == "failed"
        self._update(advance=1, failed=self._failed)

    def say(self, text: str) -> None:
        print(f"flatland: {text}", file=sys.stderr)  # noqa: T201

    def _update(self, **changes: Any) -> None:
        if self._bar is not None:
            self._bar.update(self._task, **changes)


@contextmanager
def study_progress() -> Iterator[StudyProgress]:
    """Cases done, failed and time left on a terminal's stderr; counts only, in a pipe."""
    if not sys.stderr.isatty():
        yield StudyProgress()
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[failed]} failed"),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        yield StudyProgress(bar)
