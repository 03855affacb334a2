"""The status bar: iteration, speed, where the flux went, and what went wrong."""

from __future__ import annotations

from contextlib import suppress

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar

from flatland.first_time import NOTICE, when_compiling
from gui.models.frame import Frame, flux_balance
from gui.models.session import Session

#: How long a message stays [ms].
_STAYS = 8000


class Status(QStatusBar):
    """Messages on the left; on the right what holds at the iteration on show."""

    #: Sent by whatever thread compiles.
    compiling = Signal()

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        self.unstable = QLabel()
        self.unstable.setStyleSheet("color: #d5331f; font-weight: bold")
        self.books = QLabel()
        self.books.setToolTip(
            "Flux ledger [W]: emitted + created = left + absorbed + medium + inside"
        )
        self.speed = QLabel()
        self.speed.setToolTip("Time of the last step, and steps per second at full speed")
        self.progress = QProgressBar()
        self.progress.setFixedWidth(110)
        self.progress.setTextVisible(False)
        self.progress.hide()
        for widget in (self.progress, self.unstable, self.books, self.speed):
            self.addPermanentWidget(widget)
        self._slow = QTimer(self)
        self._slow.setSingleShot(True)
        self._slow.setInterval(300)
        self._slow.timeout.connect(self._show_progress)
        session.framed.connect(self.refresh)
        session.busy_changed.connect(self._busy)
        session.references_changed.connect(self._busy)
        session.progressed.connect(self._progress)
        session.noticed.connect(lambda text: self.showMessage(first_line(text), _STAYS))
        self.compiling.connect(lambda: self.showMessage(NOTICE[0].upper() + NOTICE[1:], _STAYS))
        when_compiling(self._tell_of_compiling)
        self.refresh()

    def _tell_of_compiling(self) -> None:
        with suppress(RuntimeError):  # the window was closed meanwhile
            self.compiling.emit()

    def refresh(self) -> None:
        frame = self.session.frame
        self.unstable.setText("")
        self.books.setText("")
        self.speed.setText("")
        if frame is None:
            return
        self.books.setText(books_text(frame))
        self.speed.setText(speed_text(frame))
        if frame.unstable_at is not None:
            self.unstable.setText(f"unstable from iteration {frame.unstable_at}")

    def _busy(self) -> None:
        if self.session.busy or self.session.reference.computing:
            if not self.progress.isVisible() and not self._slow.isActive():
                self._slow.start()
        else:
            self._slow.stop()
            self.progress.hide()

    def _show_progress(self) -> None:
        if self.session.busy or self.session.reference.computing:
            self.progress.setRange(0, 0)
            self.progress.setToolTip(f"{self.session.busy or 'exact answer'}; Esc stops it")
            self.progress.show()

    def _progress(self, done: int, total: int) -> None:
        if self.progress.isVisible() and total:
            self.progress.setRange(0, total)
            self.progress.setValue(done)


def books_text(frame: Frame) -> str:
    """The flux ledger in one line."""
    if frame.ledger is None:
        return ""
    books = flux_balance(frame.ledger)
    emitted = books["emitted"]
    parts = [f"emitted {emitted:.4g} W"]
    for name in ("left", "absorbed", "medium", "inside", "created"):
        if name in ("left", "inside") or abs(books[name]) > 1e-9 * max(abs(emitted), 1e-300):
            share = 100 * books[name] / emitted if emitted else 0.0
            parts.append(f"{name} {share:.3g} %")
    return " · ".join(parts)


def speed_text(frame: Frame) -> str:
    """Iteration and the time that a step takes."""
    if frame.converged is not None:
        report = frame.converged
        return f"converged to {report.residual:.0e}, {report.applications} sweeps"
    if len(frame.fields) == 1:
        return f"answered in {frame.seconds_per_step:.2g} s"
    text = f"iteration {frame.iteration}"
    if frame.seconds_per_step == frame.seconds_per_step and frame.seconds_per_step > 0:
        text += f" · {1e3 * frame.seconds_per_step:.2g} ms a step"
    return text


def first_line(text: str) -> str:
    return text.strip().partition("\n")[0]
