"""Progress bars on a terminal, nothing in a pipe."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from studies.sweeps.case import Case
    from studies.sweeps.store import Record


@contextmanager
def steps_bar(total: int, wanted: bool = True) -> Iterator[Callable[[int], object] | None]:
    """A bar on stderr; gives the function to call with the number of steps just done."""
    if not (wanted and sys.stderr.isatty()):
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("steps", total=total)
        yield lambda count: progress.advance(task, count)


class StudyProgress:
    """Counts the cases of a study, and shows them as a bar if there is one."""

    def __init__(self, bar: Any = None) -> None:
        self._bar, self._task = bar, None
        self._kept = self._done = self._failed = self._total = 0

    @property
    def counts(self) -> tuple[int, int]:
        """Cases finished, now or before, and cases in all."""
        return self._kept + self._done, self._kept + self._total

    def begin(self, total: int, kept: int) -> None:
        self._total, self._kept = total, kept
        if self._bar is not None:
            self._task = self._bar.add_task("", total=total, failed=0)

    def stage(self, name: str) -> None:
        self._update(description=name)

    def finished(self, case: Case, record: Record) -> None:
        self._done += 1
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
