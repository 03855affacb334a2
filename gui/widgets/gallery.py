"""The built-in scenes as pictures."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QIcon, QImage, QPainter, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLabel,
    QListView,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from flatland.scene import builtin_names, builtin_text, parse_scene
from flatland.scene.catalogue import BUILTIN_DIRECTORY
from gui.models.plane import Plane
from gui.models.toml_text import tables_of
from gui.render.colours import Palette
from gui.widgets.geometry import Frame2D
from gui.widgets.scene_painter import paint_item

_SIZE = 132


class Gallery(QDialog):
    """Pick a scene by a click on its picture; pictures are drawn after the window is there."""

    def __init__(self, parent: QWidget | None, palette: Palette) -> None:
        super().__init__(parent)
        self.setWindowTitle("Built-in scenes")
        self.colours = palette
        self.chosen: str | None = None
        self.list = QListWidget()
        self.list.setViewMode(QListView.ViewMode.IconMode)
        self.list.setIconSize(QSize(_SIZE, _SIZE))
        self.list.setUniformItemSizes(True)
        self.list.setSpacing(6)
        self.list.setResizeMode(QListView.ResizeMode.Adjust)
        self.list.setMovement(QListView.Movement.Static)
        self.list.setWordWrap(True)
        blank = QPixmap(_SIZE, _SIZE)
        blank.fill(QColor(palette.paper))
        for name in builtin_names():
            item = QListWidgetItem(name)
            item.setData(Qt.ItemDataRole.UserRole, name)
            item.setTextAlignment(Qt.AlignmentFlag.AlignHCenter)
            item.setSizeHint(QSize(_SIZE + 20, _SIZE + 26))
            item.setIcon(QIcon(blank))
            self.list.addItem(item)
        self.list.itemActivated.connect(self._take)
        self.list.itemClicked.connect(self._take)
        self.about = QLabel("Choose a scene, or open a file of your own (Ctrl+O).")
        self.about.setWordWrap(True)
        self.about.setMinimumHeight(52)
        self.about.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.list.currentItemChanged.connect(lambda item, _: self._tell(item))
        self.list.setMouseTracking(True)
        self.list.itemEntered.connect(self._tell)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(self.list, 1)
        column.addWidget(self.about)
        column.addWidget(buttons)
        self.resize(860, 560)
        self._waiting = builtin_names()
        self._later = QTimer(self)
        self._later.timeout.connect(self._draw_next)
        self._later.start(0)

    def _take(self, item: QListWidgetItem) -> None:
        self.chosen = item.data(Qt.ItemDataRole.UserRole)
        self.accept()

    def _tell(self, item: QListWidgetItem | None) -> None:
        if item is not None:
            self.about.setText(description(item.data(Qt.ItemDataRole.UserRole)))

    def _draw_next(self) -> None:
        """One picture at a time, so that the window answers meanwhile."""
        if not self._waiting:
            self._later.stop()
            return
        name = self._waiting.pop(0)
        image = scene_picture(name, self.colours, _SIZE, self.devicePixelRatioF())
        for row in range(self.list.count()):
            item = self.list.item(row)
            if item.data(Qt.ItemDataRole.UserRole) == name:
                item.setIcon(QIcon(QPixmap.fromImage(image)))


def description(name: str) -> str:
    """The comment that a built-in scene begins with."""
    lines = []
    for line in builtin_text(name).splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines)


def scene_picture(name: str, palette: Palette, size: int, ratio: float) -> QImage:
    """Lights and occluders of a built-in scene."""
    text = builtin_text(name)
    scene = parse_scene(text, name, BUILTIN_DIRECTORY)
    grid, plane = scene.grid, Plane.of(scene.grid)
    side = round(size * ratio)
    image = QImage(side, side, QImage.Format.Format_RGB32)
    image.fill(QColor(palette.paper))
    image.setDevicePixelRatio(ratio)
    nx, ny = plane.shape(grid)
    zoom = side / (max(nx, ny) * 1.06)
    left, bottom = (side - nx * zoom) / 2, (side + ny * zoom) / 2
    frame = Frame2D(grid, plane, zoom, left, bottom, side, side, ratio)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    corners = frame.cell_pixels(np.array([(0, ny), (nx, 0)], float))
    painter.setPen(QColor(palette.level))
    painter.drawRect(QRectF(QPointF(*corners[0]), QPointF(*corners[1])))
    for key in ("occluder", "light"):
        for table in tables_of(text).get(key, []):
            paint_item(painter, key, table, frame, palette)
    painter.end()
    return image
