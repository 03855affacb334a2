"""Progress bars on a terminal, nothing in a pipe."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


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
