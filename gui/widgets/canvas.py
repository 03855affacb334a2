"""One view: draws a field, and hands the mouse to the tool."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import (
    QColor,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from gui.models.camera import Camera
from gui.models.display import MEANINGS
from gui.models.session import Session
from gui.widgets.geometry import Frame2D
from gui.widgets.scene_painter import paint_item, paint_selection, pen
from gui.widgets.view_painter import ViewPainter

if TYPE_CHECKING:
    from gui.mouse import Mouse


class Canvas(QWidget):
    """The cells of one view. Repaints when it is told to, and never by itself.

    painted: how often it has been drawn, for tests that nothing draws needlessly.
    """

    def __init__(
        self, view: str, session: Session, camera: Camera, painter: ViewPainter, mouse: Mouse
    ) -> None:
        super().__init__()
        self.view, self.session, self.camera = view, session, camera
        self.view_painter, self.mouse = painter, mouse
        self.painted = 0
        self._dragged_from: QPointF | None = None
        self._wheel = 0
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(120, 120)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setAccessibleName(f"{view} view")
        self.setAccessibleDescription(MEANINGS[view])

    @property
    def frame(self) -> Frame2D:
        ratio = self.devicePixelRatioF()
        size = self.width() * ratio, self.height() * ratio
        return Frame2D.of(self.session.scene.grid, self.session.plane, self.camera, *size, ratio)

    # -- drawing --------------------------------------------------------------------------------

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        self.painted += 1
        painter = QPainter(self)
        try:
            self._paint(painter)
        finally:
            painter.end()  # Qt ends the program if a painter outlives its device

    def _paint(self, painter: QPainter) -> None:
        palette, frame = self.view_painter.stage.palette, self.frame
        painter.fillRect(self.rect(), QColor(palette.outside))
        if self.session.field(self.view) is None:
            self._paint_hint(painter)
        self.view_painter.paint(painter, self.view, frame)
        paint_selection(painter, self.view_painter.items, frame, palette)
        self._paint_cells(painter, frame)
        self._paint_mouse(painter, frame)
        self._paint_legend(painter)

    def _paint_legend(self, painter: QPainter) -> None:
        """What the colours mean, where several fields share the cells."""
        entries = self.view_painter.stage.legend(self.view)
        if not entries:
            return
        palette, metrics = self.view_painter.stage.palette, painter.fontMetrics()
        line = metrics.height()
        width = max(metrics.horizontalAdvance(name) for _, name in entries) + line + 14
        paper = QColor(palette.paper)
        paper.setAlphaF(0.88)
        box = QRectF(self.width() - width - 6, 6, width, len(entries) * line + 8)
        painter.setPen(QColor(palette.grid))
        painter.setBrush(paper)
        painter.drawRect(box)
        for row, (colour, name) in enumerate(entries):
            top = box.top() + 4 + row * line
            painter.fillRect(
                QRectF(box.left() + 6, top + 0.25 * line, 10, 0.5 * line), QColor(colour)
            )
            painter.setPen(QColor(palette.ink))
            painter.drawText(QPointF(box.left() + 22, top + metrics.ascent()), name)

    def _paint_hint(self, painter: QPainter) -> None:
        text = self._hint()
        painter.setPen(QColor(self.view_painter.stage.palette.faint))
        box = self.rect().adjusted(8, 8, -8, -8)
        painter.drawText(box, Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignBottom, text)

    def _hint(self) -> str:
        """Why there is nothing to see."""
        session = self.session
        if self.view in ("reference", "difference"):
            waiting = session.reference.computing
            return "computing the exact answer …" if waiting else "no exact answer yet: press X"
        if session.busy:
            return "working …"
        if not session.choice.steps and self.view != "accumulated":
            return "this method does not step"
        return "no light yet: press I"

    def _paint_cells(self, painter: QPainter, frame: Frame2D) -> None:
        """Rings round the pinned cell and the one under the mouse."""
        palette = self.view_painter.stage.palette
        painter.setBrush(Qt.BrushStyle.NoBrush)
        selection = self.session.selection
        for cell, width in ((selection.hovered, 1.0), (selection.pinned, 2.0)):
            if cell is None or len(cell) != frame.grid.dimension:
                continue
            if frame.plane.normal is not None and cell[frame.plane.normal] != frame.plane.layer:
                continue
            low = frame.plane.project(np.array(cell, float))
            corners = frame.cell_pixels(low + np.array([(0.0, 1.0), (1.0, 0.0)]))
            painter.setPen(pen(palette.selected, width))
            painter.drawRect(QRectF(QPointF(*corners[0]), QPointF(*corners[1])))

    def _paint_mouse(self, painter: QPainter, frame: Frame2D) -> None:
        """What the stroke in hand would make."""
        palette = self.view_painter.stage.palette
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for name, table in self.mouse.ghosts():
            paint_item(painter, name, table, frame, palette, ghost=True)
        if self.mouse.rectangle is not None:
            corners = frame.pixels(np.array(self.mouse.rectangle))
            painter.setPen(pen(palette.selected, 1.0, True))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(QRectF(QPointF(*corners[0]), QPointF(*corners[1])).normalized())

    # -- the mouse ------------------------------------------------------------------------------

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if event.button() == Qt.MouseButton.MiddleButton or self.mouse.pans(event):
            self._dragged_from = event.position()
            self.setCursor(Qt.CursorShape.ClosedHandCursor)
        else:
            self.mouse.press(self, event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        at = event.position()
        if self._dragged_from is not None:
            moved = (at - self._dragged_from) * self.devicePixelRatioF()
            self._dragged_from = at
            self.camera.pan(moved.x(), -moved.y())
            return
        self.session.selection.hover(self.frame.cell_at(at.x(), at.y()))
        self.mouse.move(self, event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._dragged_from is not None:
            self._dragged_from = None
            self.mouse.set_cursor(self)
        else:
            self.mouse.release(self, event)

    def leaveEvent(self, event: object) -> None:  # noqa: N802
        self.session.selection.hover(None)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        self._wheel += event.angleDelta().y()
        steps, self._wheel = int(self._wheel / 120), int(np.fmod(self._wheel, 120))
        if steps:
            at = event.position()
            self.camera.zoom_by(steps, self.frame.cell_place(at.x(), at.y()))
        event.accept()
