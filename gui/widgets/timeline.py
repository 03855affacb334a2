"""The time line: run, step, and any earlier iteration."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QSlider,
    QSpinBox,
    QToolButton,
    QWidget,
)

from gui.models.session import Session
from gui.widgets.blocking import quiet


class TimeLine(QWidget):
    """Buttons of the run's actions, a slider over the iterations so far, and how fast to go."""

    def __init__(self, session: Session, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self.session = session
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 2, 4, 2)
        row.setSpacing(3)
        for name in ("inject", "first", "back", "run", "step", "last", "solve"):
            button = QToolButton()
            button.setDefaultAction(actions[name])
            button.setAutoRaise(True)
            button.setAccessibleName(actions[name].text())
            row.addWidget(button)
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setToolTip("Any iteration so far: drag, or use the arrow keys")
        self.slider.setAccessibleName("Iteration")
        self.slider.valueChanged.connect(session.go_to)
        row.addWidget(self.slider, 1)
        self.number = QLabel("0 / 0")
        self.number.setMinimumWidth(76)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.number.setToolTip("Iteration on show / last one reached")
        row.addWidget(self.number)
        self.count = QSpinBox()
        self.count.setRange(1, 100_000)
        self.count.setValue(32)
        self.count.setToolTip("Iterations of an automated run")
        self.run_button = QToolButton()
        self.run_button.setDefaultAction(actions["run_count"])
        row.addWidget(self.count)
        row.addWidget(self.run_button)
        self.rate = QDoubleSpinBox()
        self.rate.setRange(0, 1000)
        self.rate.setDecimals(0)
        self.rate.setSpecialValueText("full speed")
        self.rate.setSuffix(" steps/s")
        self.rate.setToolTip("Pace of Run: iterations per second; 0: as fast as it goes")
        self.rate.valueChanged.connect(lambda value: session.display.set(rate=value or None))
        row.addWidget(self.rate)
        for widget in (self.slider, self.count, self.rate):
            widget.setMinimumWidth(60)
        session.framed.connect(self.refresh)
        session.tracked.connect(self.refresh)
        session.display.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        last, now = self.session.last_iteration, self.session.iteration
        solved = self.session.frame is not None and self.session.frame.converged is not None
        with quiet(self.slider, self.rate):
            self.slider.setRange(0, max(last, now))
            if not self.slider.isSliderDown():
                self.slider.setValue(last if solved else now)
            self.rate.setValue(self.session.display.look.rate or 0)
        self.number.setText(f"∞ / {last}" if solved else f"{now} / {last}")
