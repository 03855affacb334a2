"""Small signs for buttons, drawn in the colour of the text, sharp at every resolution."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QIconEngine, QPainter, QPixmap, QPolygonF
from PySide6.QtWidgets import QApplication

#: Triangles (left, right, pointing right or left) and bars (left, right) on a square of side 16.
_SIGNS: dict[str, tuple[tuple[tuple[float, float, bool], ...], tuple[tuple[float, float], ...]]] = {
    "run": (((4, 13, True),), ()),
    "pause": ((), ((4, 7), (9, 12))),
    "step": (((3, 10, True),), ((11, 13),)),
    "back": (((6, 13, False),), ((3, 5),)),
    "last": (((2, 7.5, True), (7.5, 13, True)), ((13, 14.5),)),
    "first": (((8.5, 14, False), (3, 8.5, False)), ((1.5, 3),)),
}


class _Engine(QIconEngine):
    def __init__(self, name: str) -> None:
        super().__init__()
        self.name = name

    def clone(self) -> QIconEngine:
        return _Engine(self.name)

    def paint(self, painter: QPainter, rect: object, mode: QIcon.Mode, state: QIcon.State) -> None:
        area = QRectF(rect)  # type: ignore[call-overload]
        palette = QApplication.palette()
        group = palette.ColorGroup.Active
        if mode == QIcon.Mode.Disabled:
            group = palette.ColorGroup.Disabled
        draw_sign(painter, self.name, area, palette.color(group, palette.ColorRole.ButtonText))

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        pixmap = QPixmap(size)
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        self.paint(painter, QRectF(0, 0, size.width(), size.height()), mode, state)
        painter.end()
        return pixmap


def icon(name: str) -> QIcon:
    """A sign by its name."""
    return QIcon(_Engine(name))


def draw_sign(painter: QPainter, name: str, area: QRectF, colour: QColor) -> None:
    """A sign on any painter."""
    triangles, bars = _SIGNS[name]
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.translate(area.topLeft())
    painter.scale(area.width() / 16, area.height() / 16)
    for left, right, forward in triangles:
        base, tip = (left, right) if forward else (right, left)
        painter.drawPolygon(QPolygonF([QPointF(base, 3), QPointF(base, 13), QPointF(tip, 8)]))
    for left, right in bars:
        painter.drawRect(QRectF(left, 3, right - left, 10))
    painter.restore()
