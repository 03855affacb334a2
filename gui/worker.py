"""Work off the GUI's thread: one queue of jobs, one thread, answers as signals."""

from __future__ import annotations

import queue
import threading
import traceback
from typing import Any, Protocol

from PySide6.QtCore import QObject, QThread, QTimer, Signal, Slot

from flatland.errors import FlatlandError
from gui.models.frame import Frame
from gui.models.helper import HelperError
from gui.models.jobs import Cancelled, Job, Watch
from gui.models.track import Row

#: The longest that a run waits for its last frame to be drawn [s].
DRAWING = 0.25


class Performer(Protocol):
    """Who does the jobs, in the worker's thread alone."""

    def perform(self, job: Job, watch: Watch) -> Any: ...


class _Watch:
    """The worker's ear for one job."""

    def __init__(self, worker: Worker, job: Job, epoch: int) -> None:
        self._worker, self._job, self._epoch = worker, job, epoch

    def cancelled(self) -> bool:
        return self._epoch != self._worker.epoch

    def sleep(self, seconds: float) -> None:
        self._worker.wake.wait(seconds)

    def publish(self, frame: Frame, rows: list[Row]) -> None:
        """Hand a frame over, and let the window draw it before the next step is taken.

        Both threads run Python: without the rest, every call of the window waits for its turn.
        """
        self._worker.hand_over(self._job.stamp, frame, rows)
        if not self.cancelled():
            self._worker.drawn.wait(DRAWING)

    def progress(self, done: int, total: int) -> None:
        self._worker.told_progress.emit(done, total)

    def notice(self, text: str) -> None:
        self._worker.noticed.emit(text)


class Worker(QThread):
    """Does jobs one after another. Frames nobody has taken yet are replaced, never queued up.

    Signals, all received on the thread that made the worker: `arrived` (stamp, frame, rows),
    `finished_job` (job, result or None if cancelled or failed), `failed` (stamp, title, text,
    details), `busy_with` (kind of the job, "" when there is none), `told_progress`, `noticed`.
    """

    arrived = Signal(int, object, object)
    finished_job = Signal(object, object)
    failed = Signal(int, str, str, str)
    busy_with = Signal(str)
    told_progress = Signal(int, int)
    noticed = Signal(str)
    _ready = Signal()

    def __init__(self, performer: Performer, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.performer = performer
        self.epoch = 0
        self.wake = threading.Event()
        self.drawn = threading.Event()
        self._jobs: queue.Queue[tuple[int, Job] | None] = queue.Queue()
        self._lock = threading.Lock()
        self._latest: tuple[int, Frame, list[Row]] | None = None
        self._working = False
        self._ready.connect(self._take)

    # -- called on the GUI's thread -------------------------------------------------------------

    def submit(self, job: Job) -> None:
        if not self.isRunning():
            self.start()
        if job.kind == "go_to":
            self._drop("go_to")
        self._jobs.put((self.epoch, job))

    def cancel(self) -> None:
        """Stop the job in hand within an iteration, and forget those that wait."""
        self.epoch += 1
        self.wake.set()
        self.drawn.set()
        self._drop()

    @property
    def waiting(self) -> int:
        """Jobs in hand or waiting."""
        return self._jobs.qsize() + self._working

    def close(self, milliseconds: int = 5000) -> bool:
        """Stop for good. Whether the thread ended in time."""
        self.cancel()
        self._jobs.put(None)
        return self.wait(milliseconds) if self.isRunning() else True

    def _drop(self, kind: str | None = None) -> None:
        """Take jobs out of the queue, all or those of a kind, and say that they are over."""
        kept, dropped = [], []
        while True:
            try:
                entry = self._jobs.get_nowait()
            except queue.Empty:
                break
            if entry is None or (kind is not None and entry[1].kind != kind):
                kept.append(entry)
            else:
                dropped.append(entry[1])
        for entry in kept:
            self._jobs.put(entry)
        for job in dropped:
            self.finished_job.emit(job, None)

    @Slot()
    def _take(self) -> None:
        with self._lock:
            latest, self._latest = self._latest, None
        if latest is not None:
            self.arrived.emit(*latest)
        # After the paint events that this has posted.
        QTimer.singleShot(0, self.drawn.set)

    # -- called on the worker's thread ----------------------------------------------------------

    def hand_over(self, stamp: int, frame: Frame, rows: list[Row]) -> None:
        with self._lock:
            self.drawn.clear()
            waiting = self._latest
            if waiting is not None and waiting[0] == stamp:
                rows = [*waiting[2], *rows]
            self._latest = stamp, frame, rows
        if waiting is None:
            self._ready.emit()

    def run(self) -> None:
        while (entry := self._jobs.get()) is not None:
            epoch, job = entry
            if epoch != self.epoch:
                self.finished_job.emit(job, None)
                continue
            self.wake.clear()
            self._working = True
            self.busy_with.emit(job.kind)
            result = None
            try:
                result = self.performer.perform(job, _Watch(self, job, epoch))
            except Cancelled:
                pass
            except FlatlandError as error:
                self.failed.emit(job.stamp, "This cannot be done", str(error), "")
            except HelperError as error:
                self.failed.emit(job.stamp, "A fault of flatland", str(error), error.details or "-")
            except Exception as error:  # noqa: BLE001 - told to the user, the thread goes on
                text = f"{type(error).__name__}: {error}"
                self.failed.emit(job.stamp, "A fault of flatland", text, traceback.format_exc())
            self._working = False
            self.finished_job.emit(job, result)
            if self._jobs.empty():
                self.busy_with.emit("")
