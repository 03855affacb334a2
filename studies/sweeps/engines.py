"""Where cases run: here, in processes of this machine, or on a Dask cluster.

All three are `concurrent.futures` executors; `drive` is the one loop that feeds them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from dataclasses import dataclass
from typing import Any

from flatland.errors import FlatlandError, bad_input
from studies.machine import describe_machine

#: One thread a worker: pools of threads in a pool of processes fight for the processors. Set
#: before a worker starts, as libraries read them when they are loaded.
ONE_THREAD = {
    "FLATLAND_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
}
#: A task whose worker died so often is given up.
MOST_DEATHS = 2
#: How long to wait for a worker that was told to end [s].
_PATIENCE = 10


@dataclass(frozen=True)
class Task:
    """A call of a module's function with plain arguments, and the name its answer goes by."""

    key: str
    call: Callable[..., Any]
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Death:
    """The answer of a task that has none: its worker died, or could not answer."""

    reason: str


class EngineLostError(FlatlandError, ConnectionError):
    """The engine is gone, and nothing can be run on it any more."""


class Engine(ABC):
    """Makes executors. slots: tasks that may be under way at once."""

    name: str
    slots: int

    @abstractmethod
    def open(self) -> Executor:
        """A new executor, ready for work."""

    @abstractmethod
    def close(self, executor: Executor, at_once: bool) -> None:
        """End an executor. at_once: without waiting for what is under way."""


class Serial(Engine):
    """Everything in this process, one after another."""

    name, slots = "serial", 1

    def open(self) -> Executor:
        return _HereExecutor()

    def close(self, executor: Executor, at_once: bool) -> None:
        return


class _HereExecutor(Executor):
    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - the future carries it to who asks
            future.set_exception(error)
        return future


class Processes(Engine):
    """Fresh processes of this machine, one thread each; they end with this process.

    A worker ignores Ctrl-C, which is for its parent, and dies when its parent is gone.
    """

    name = "processes"

    def __init__(self, slots: int) -> None:
        self.slots = slots
        self._before: dict[str, str | None] = {}
        self._others: set[Any] = set()

    def open(self) -> Executor:
        self._before = {name: os.environ.get(name) for name in ONE_THREAD}
        os.environ.update(ONE_THREAD)
        self._others = set(multiprocessing.active_children())
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self.slots, context, initializer=_begin_worker)

    def close(self, executor: Executor, at_once: bool) -> None:
        children = set(multiprocessing.active_children()) - self._others
        executor.shutdown(wait=not at_once, cancel_futures=True)
        if at_once:
            for child in children:
                child.terminate()
            for child in children:
                child.join(_PATIENCE)
        for name, value in self._before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _begin_worker() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_die_with_parent, daemon=True).start()


def _die_with_parent() -> None:
    """A parent that is killed tells nobody, and its workers would wait for work for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def local_engine(jobs: int | None = None) -> Engine:
    """This machine: so many processes, all processors if None; with 1, this process alone.

    Raises InputError.
    """
    count = describe_machine()["processors"] if jobs is None else jobs
    if count < 1:
        raise bad_input("--jobs", count, "must be at least 1")
    return Serial() if count == 1 else Processes(count)


def drive(engine: Engine, tasks: Iterable[Task]) -> Generator[tuple[Task, Any], None, None]:
    """Each task with its answer, as they come; a Death for those that have none.

    When a process pool breaks, every task under way may have broken it. Each is tried again, alone,
    so that the guilty one is known, and given up when it breaks the pool a second time.
    Raises EngineLostError when the engine is gone. Closing the generator stops what is under way.
    """
    waiting, suspects = deque(tasks), deque[Task]()
    deaths: Counter[str] = Counter()
    running: dict[Future[Any], Task] = {}
    executor = engine.open()
    try:
        while waiting or suspects or running:
            _submit(executor, engine.slots, waiting, suspects, running)
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            lost: list[Task] = []
            for future in finished:
                task = running.pop(future)
                answer = _answer(future)
                if answer is None:
                    lost.append(task)
                else:
                    yield task, answer
            if lost:
                lost += running.values()
                running.clear()
                engine.close(executor, at_once=True)
                executor = engine.open()
                for task in lost:
                    deaths[task.key] += 1
                    if len(lost) == 1 and deaths[task.key] >= MOST_DEATHS:
                        yield task, Death("its worker process died (killed, or out of memory)")
                    else:
                        suspects.append(task)
    finally:
        engine.close(executor, at_once=bool(running))


def _submit(
    executor: Executor,
    slots: int,
    waiting: deque[Task],
    suspects: deque[Task],
    running: dict[Future[Any], Task],
) -> None:
    """Suspects one at a time and alone, then as many as there are slots."""
    if suspects:
        if not running:
            _start(executor, suspects.popleft(), running)
        return
    while waiting and len(running) < slots:
        _start(executor, waiting.popleft(), running)


def _start(executor: Executor, task: Task, running: dict[Future[Any], Task]) -> None:
    try:
        future = executor.submit(task.call, *task.arguments)
    except BrokenExecutor as error:
        future = Future()
        future.set_exception(error)
    running[future] = task


def _answer(future: Future[Any]) -> Any:
    """The answer or the Death of a task, None if its executor broke."""
    try:
        return future.result()
    except BrokenExecutor:
        return None
    except CancelledError:
        message = "the connection to the workers is lost; finished cases are kept"
        raise EngineLostError(message) from None
    except Exception as error:  # noqa: BLE001 - such as a worker that Dask gave up
        return Death(f"{type(error).__name__}: {error}")
