"""Live curves over iterations: energy, and errors against the exact answer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from PySide6.QtCore import QPointF, QRectF, Qt, QTimer
from PySide6.QtGui import QColor, QFontMetricsF, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QSizePolicy, QVBoxLayout, QWidget

from gui.models.measures import ERRORS
from gui.models.session import Session
from gui.models.track import ENERGY, Track
from gui.render.stage import Stage
from gui.widgets.polar import nice_step

#: What can be drawn together: name, entries, unit.
GROUPS: dict[str, tuple[tuple[str, ...], str]] = {
    "Energy": (("left", "absorbed", "inside", "created"), "W"),
    "Relative error": (("mean_relative", "max_relative", "coefficients"), ""),
    "Absolute error": (("mean_absolute", "max_absolute"), "W per unit angle"),
}
#: Names in the legend, where the group says the rest.
SHORT = {
    "mean_relative": "mean",
    "max_relative": "max",
    "coefficients": "L2",
    "mean_absolute": "mean",
    "max_absolute": "max",
}
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
#: Most points of a line that are drawn; a screen has no more.
_MOST = 1500


@dataclass(frozen=True)
class Line:
    """One curve. dashed: of a kept run."""

    name: str
    x: list[int]
    y: list[float]
    colour: str
    dashed: bool = False


class CurvePlot(QWidget):
    """Lines over iterations, drawn by hand: a redraw costs a millisecond."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[Line] = []
        self.unit, self.hint = "", ""
        self.logarithmic = False
        self.now: int | None = None
        self._mouse: float | None = None
        self.painted = 0
        self.setMinimumSize(180, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMouseTracking(True)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        self.painted += 1
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw_curves(
            painter, QRectF(self.rect()), self.lines, self.unit, self.logarithmic, self.now,
            self._mouse, self.palette().base().color(), self.palette().text().color(), self.hint,
        )  # fmt: skip
        painter.end()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        self._mouse = event.position().x()
        self.update()

    def leaveEvent(self, event: object) -> None:  # noqa: N802
        self._mouse = None
        self.update()


def draw_curves(
    painter: QPainter,
    area: QRectF,
    lines: list[Line],
    unit: str,
    logarithmic: bool,
    now: int | None,
    mouse: float | None,
    paper: QColor,
    ink: QColor,
    hint: str = "",
) -> None:
    """The plot on any painter."""
    painter.fillRect(area, paper)
    metrics = QFontMetricsF(painter.font())
    shown = [line for line in lines if len(line.x) > 0]
    if logarithmic:
        shown = [line for line in shown if max(line.y) > 0]
    legend = metrics.height() * max(1, math.ceil(len(shown) / 2)) + 4
    box = area.adjusted(
        metrics.horizontalAdvance("-0.00e-00") + 2, legend + 4, -10, -2.2 * metrics.height()
    )
    if not shown or box.width() < 20 or box.height() < 20:
        painter.setPen(ink)
        painter.drawText(area, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, hint)
        return
    last = max(max(line.x[-1] for line in shown), 1)
    low, high = _range(shown, logarithmic)

    def places(x: ArrayLike, y: ArrayLike) -> list[QPointF]:
        values = np.asarray(y, float)
        values = np.log10(np.maximum(values, 10.0**low)) if logarithmic else values
        up = np.clip((values - low) / (high - low), -0.05, 1.05)
        across = box.left() + np.asarray(x, float) / last * box.width()
        return list(map(QPointF, across.tolist(), (box.bottom() - up * box.height()).tolist()))

    _axes(painter, box, last, low, high, logarithmic, ink, unit)
    painter.save()
    painter.setClipRect(box.adjusted(-1, -1, 1, 1))
    for line in shown:
        pen = QPen(QColor(line.colour), 1.6)
        if line.dashed:
            pen.setDashPattern([4, 2.5])
        painter.setPen(pen)
        every = max(1, len(line.x) // _MOST)
        points = places(line.x[::every], line.y[::every])
        if len(points) == 1:
            painter.drawEllipse(points[0], 2, 2)
        painter.drawPolyline(QPolygonF(points))
    cursor = _cursor(box, last, mouse, now)
    if cursor is not None:
        painter.setPen(QPen(ink, 0.8, Qt.PenStyle.DotLine))
        x = places([cursor], [1.0])[0].x()
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
    painter.restore()
    _legend(painter, area, shown, cursor, metrics, ink)


def _cursor(box: QRectF, last: int, mouse: float | None, now: int | None) -> int | None:
    if mouse is not None and box.left() <= mouse <= box.right():
        return round((mouse - box.left()) / box.width() * last)
    return now


def _range(lines: list[Line], logarithmic: bool) -> tuple[float, float]:
    values = np.concatenate([np.asarray(line.y, float) for line in lines])
    values = values[np.isfinite(values)]
    if logarithmic:
        values = values[values > 0]
        high = math.log10(float(values.max()))
        low = max(math.log10(float(values.min())), high - 12)
        return math.floor(low - 1e-9), max(math.ceil(high), math.floor(low - 1e-9) + 1)
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 0.0)
    return low, high + (0.05 * (high - low) if high > low else 1.0)


def _axes(
    painter: QPainter, box: QRectF, last: int, low: float, high: float, logarithmic: bool,
    ink: QColor, unit: str,
) -> None:  # fmt: skip
    faint = QColor(ink)
    faint.setAlphaF(0.2)
    metrics = QFontMetricsF(painter.font())
    step = max(1.0, math.ceil((high - low) / 6)) if logarithmic else nice_step(high - low)
    value = math.ceil(low / step) * step
    while value <= high + 1e-9 * step:
        y = box.bottom() - (value - low) / (high - low) * box.height()
        painter.setPen(faint)
        painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
        painter.setPen(ink)
        text = f"1e{round(value)}" if logarithmic else f"{value:.4g}"
        side = QRectF(0, y - metrics.height() / 2, box.left() - 5, metrics.height())
        painter.drawText(side, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, text)
        value += step
    across = max(1, round(nice_step(last)))
    for x in range(0, last + 1, across):
        at = box.left() + x / last * box.width()
        painter.setPen(faint)
        painter.drawLine(QPointF(at, box.top()), QPointF(at, box.bottom()))
        painter.setPen(ink)
        below = QRectF(at - 40, box.bottom() + 2, 80, metrics.height())
        painter.drawText(below, Qt.AlignmentFlag.AlignHCenter, str(x))
    label = QRectF(box.left(), box.bottom() + metrics.height(), box.width(), metrics.height() + 2)
    text = f"iteration; {unit}" if unit else "iteration"
    painter.drawText(label, Qt.AlignmentFlag.AlignHCenter, text)


def _legend(
    painter: QPainter, area: QRectF, lines: list[Line], cursor: int | None,
    metrics: QFontMetricsF, ink: QColor,
) -> None:  # fmt: skip
    width = (area.width() - 12) / 2
    for index, line in enumerate(lines):
        row, column = divmod(index, 2)
        x, y = area.left() + 6 + column * width, area.top() + 4 + row * metrics.height()
        middle = y + metrics.height() / 2
        pen = QPen(QColor(line.colour), 2)
        if line.dashed:
            pen.setDashPattern([3, 2])
        painter.setPen(pen)
        painter.drawLine(QPointF(x, middle), QPointF(x + 14, middle))
        text = line.name.replace("_", " ")
        if cursor is not None and cursor in line.x:
            text += f" {line.y[line.x.index(cursor)]:.3g}"
        painter.setPen(ink)
        room = QRectF(x + 18, y, width - 20, metrics.height())
        painter.drawText(
            room, 0, metrics.elidedText(text, Qt.TextElideMode.ElideRight, room.width())
        )


class CurvesPanel(QWidget):
    """The plot and what it shows; redrawn at most thirty times a second."""

    def __init__(self, session: Session, stage: Stage) -> None:
        super().__init__()
        self.session, self.stage = session, stage
        self.group = QComboBox()
        self.group.addItems(list(GROUPS))
        self.group.currentIndexChanged.connect(self._grouped)
        self.logarithmic = QCheckBox("Log")
        self.logarithmic.setToolTip("Logarithmic axis")
        self.logarithmic.toggled.connect(self.refresh)
        self.kept = QCheckBox("Kept runs")
        self.kept.setChecked(True)
        self.kept.setToolTip("Draw kept runs, dashed")
        self.kept.toggled.connect(self.refresh)
        self.plot = CurvePlot()
        row = QHBoxLayout()
        for widget in (self.group, self.logarithmic, self.kept):
            row.addWidget(widget)
        row.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(4, 4, 4, 2)
        column.addLayout(row)
        column.addWidget(self.plot, 1)
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.setInterval(33)
        self._later.timeout.connect(self.refresh)
        session.display.changed.connect(self._soon)
        for event in (session.tracked, session.framed, session.runs_changed):
            event.connect(self._soon)
        session.references_changed.connect(self._soon)
        self.refresh()

    def _soon(self) -> None:
        if not self._later.isActive():
            self._later.start()

    def _grouped(self) -> None:
        self.logarithmic.setChecked(GROUPS[self.group.currentText()][1] != "W")
        self.refresh()

    def refresh(self) -> None:
        names, unit = GROUPS[self.group.currentText()]
        if names[0] in ERRORS and self.session.level is not None:
            names = tuple(f"{name}@{self.session.level}" for name in names)
        lines = self._lines(self.session.track, names)
        if self.kept.isChecked():
            for run in self.session.runs:
                if run.visible:
                    lines += self._lines(run.track, names, run.scheme)
        self.plot.lines, self.plot.unit = lines, unit
        self.plot.logarithmic = self.logarithmic.isChecked()
        frame = self.session.frame
        self.plot.now = frame.iteration if frame and frame.converged is None else None
        needs = names[0].partition("@")[0] in ERRORS and self.session.exact is None
        self.plot.hint = "Press X for the exact answer" if needs else "Press Space to run"
        meanings = {**ENERGY, **ERRORS}
        self.plot.setToolTip(
            "\n".join(f"{n.replace('_', ' ')}: {meanings[n.partition('@')[0]]}" for n in names)
        )
        self.plot.update()

    def _lines(self, track: Track, names: tuple[str, ...], label: str = "") -> list[Line]:
        lines = []
        for index, name in enumerate(names):
            x, y = track.series(name)
            if x and any(y):
                plain, at, level = name.partition("@")
                title = SHORT.get(plain, plain) + (f", level {level}" if at else "")
                title += f" ({label})" if label else ""
                lines.append(Line(title, x, y, COLOURS[index], bool(label)))
        return lines
