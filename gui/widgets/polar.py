"""A large polar plot of what leaves one cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """Intensity (K,) over evenly spread angles. filled: drawn as a surface."""

    name: str
    values: Array
    colour: str
    filled: bool = False


class PolarPlot(QWidget):
    """Curves on one linear scale; negative parts dashed in their own colour."""

    def __init__(self) -> None:
        super().__init__()
        self.curves: list[Curve] = []
        self.unit, self.hint = "W/rad", ""
        self.negative = "#8a2be2"
        self.setMinimumSize(150, 150)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setToolTip("Intensity over direction of travel: x to the right, y up")

    def show_curves(self, curves: list[Curve], unit: str) -> None:
        self.curves, self.unit = curves, unit
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw_polar(
            painter, self.width(), self.height(), self.curves, self.unit, self.negative,
            self.palette().base().color(), self.palette().text().color(), self.hint,
        )  # fmt: skip
        painter.end()


def draw_polar(
    painter: QPainter,
    width: float,
    height: float,
    curves: list[Curve],
    unit: str,
    negative: str,
    paper: QColor,
    ink: QColor,
    hint: str = "",
) -> None:
    """The plot on any painter. hint: shown if there is no light."""
    painter.fillRect(0, 0, int(width), int(height), paper)
    middle = np.array([width / 2, height / 2 - 4])
    radius = max(min(width, height) / 2 - 18, 10)
    top = max((float(np.abs(c.values).max(initial=0)) for c in curves), default=0.0)
    faint = QColor(ink)
    faint.setAlphaF(0.25)
    if top <= 0:
        painter.setPen(faint)
        painter.drawEllipse(QPointF(*middle), radius, radius)
        painter.setPen(ink)
        box = QRectF(0, 0, width, height)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, hint or "no light here")
        return
    _rings(painter, middle, radius, top, unit, faint, ink)
    for curve in curves:
        for sign, colour in ((1, curve.colour), (-1, negative)):
            points = _points(np.maximum(sign * curve.values, 0) / top * radius, middle)
            if points is None:
                continue
            line = QPen(QColor(colour), 1.8)
            if sign < 0:
                line.setDashPattern([3, 2])
            fill = QColor(curve.colour)
            fill.setAlphaF(0.55)
            filled = curve.filled and sign > 0
            painter.setPen(Qt.PenStyle.NoPen if filled else line)
            painter.setBrush(fill if filled else Qt.BrushStyle.NoBrush)
            painter.drawPolygon(points)


def _rings(
    painter: QPainter,
    middle: Array,
    radius: float,
    top: float,
    unit: str,
    faint: QColor,
    ink: QColor,
) -> None:
    step = nice_step(top)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(faint, 1))
    for k in range(1, 8):
        if k * step > top * 1.001:
            break
        size = k * step / top * radius
        painter.drawEllipse(QPointF(*middle), size, size)
    for angle in np.arange(8) * np.pi / 4:
        end = middle + radius * np.array([np.cos(angle), -np.sin(angle)])
        painter.drawLine(QPointF(*middle), QPointF(*end))
    painter.setPen(ink)
    painter.drawText(QPointF(4, middle[1] + radius + 17), f"ring {step:.3g} {unit}")


def _points(radii: Array, middle: Array) -> QPolygonF | None:
    if radii.max() < 0.3:
        return None
    angles = np.arange(radii.size) * (2 * np.pi / radii.size)
    x, y = middle[0] + radii * np.cos(angles), middle[1] - radii * np.sin(angles)
    return QPolygonF([QPointF(a, b) for a, b in zip(x, y)])


def nice_step(top: float) -> float:
    """A round number that divides `top` into two to five parts."""
    if not top > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(top))
    for factor in (0.2, 0.5, 1.0, 2.0, 5.0):
        if top / (factor * power) <= 5:
            return float(factor * power)
    return float(power)
