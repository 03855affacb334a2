"""A whole view on any painter: the canvas, an image, or a vector file."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QImage, QPainter, QPen

from gui.models.session import Session
from gui.render.colours import Packed
from gui.render.outlines import lobe_outlines
from gui.render.picture import LEAST_FOR_LOBES, Layer, heat_colours, paint
from gui.render.stage import Stage
from gui.widgets.geometry import Frame2D
from gui.widgets.scene_painter import SceneLayer, paint_items, pen, polygon

#: From so many device pixels a cell on, lobes are drawn as exact outlines.
EXACT_FROM = 96
#: Pictures of lights and occluders that are kept, one per size of view.
_SCENES = 4


class ViewPainter:
    """Draws views of a session; keeps the last picture of each, to blit it again."""

    def __init__(self, session: Session, stage: Stage) -> None:
        self.session, self.stage = session, stage
        self.items = SceneLayer(session)
        self._images: dict[str, tuple[object, QImage, Packed]] = {}
        self._scenes: dict[object, QImage] = {}

    def paint(self, painter: QPainter, view: str, frame: Frame2D, vector: bool = False) -> None:
        """Light, borders and scene. vector: outlines instead of pixels, whatever the zoom."""
        look, field = self.session.display.look, self.session.field(view)
        there = frame
        if field is not None and field.grid != frame.grid:
            there = frame.on(field.grid, self.session.plane_on(field.grid))
        self._paint_light(painter, view, there, vector)
        self._paint_levels(painter, view, frame)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_border(painter, frame)
        if vector:
            paint_items(painter, self.items, frame, self.stage.palette, look.layers)
        else:
            painter.drawImage(QPointF(0, 0), self._scene_image(frame))

    def _scene_image(self, frame: Frame2D) -> QImage:
        """Lights and occluders on nothing, drawn once for all views of a size."""
        palette, layers = self.stage.palette, self.session.display.look.layers
        key = (self.session.document.text, frame, palette, layers)
        if key not in self._scenes:
            while len(self._scenes) >= _SCENES:
                del self._scenes[next(iter(self._scenes))]
            size = round(frame.width), round(frame.height)
            image = QImage(*size, QImage.Format.Format_ARGB32_Premultiplied)
            image.fill(0)
            image.setDevicePixelRatio(frame.ratio)
            painter = QPainter(image)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            paint_items(painter, self.items, frame, palette, layers)
            painter.end()
            self._scenes[key] = image
        return self._scenes[key]

    def _paint_light(self, painter: QPainter, view: str, frame: Frame2D, vector: bool) -> None:
        window = frame.window
        if min(r.stop - r.start for r in window) <= 0:
            return
        look = self.session.display.look
        # Thinner lines round small lobes, so that they do not hide what they enclose.
        thin = min(1.0, frame.zoom / frame.ratio / 18)
        layers = self.stage.layers(view, thin * frame.ratio)
        cells = frame.zoom < LEAST_FOR_LOBES or look.heat == "instead of lobes"
        outlines = not cells and (vector or frame.zoom >= EXACT_FROM)
        if cells or vector:
            self._paint_cells(painter, view, frame, faded=not cells)
        else:
            pixels = int(frame.zoom)
            image = self._image(view, layers, frame, pixels, not outlines)
            left, top = frame.cell_pixels(np.array([window[0].start, window[1].stop]))
            painter.drawImage(QPointF(left, top), image)
        if vector and "grid" in look.layers and not cells:
            self._paint_grid(painter, frame)
        if outlines:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            for layer in layers:
                self._paint_outlines(painter, layer, view, frame)

    def _image(
        self, view: str, layers: list[Layer], frame: Frame2D, pixels: int, lobes: bool
    ) -> QImage:
        """The picture of the visible cells, made anew only if something in it changed."""
        look, scale = self.session.display.look, self.stage.scale(view)
        window, palette = frame.window, self.stage.palette
        borders = "grid" in look.layers and pixels >= 8
        bounds = tuple((r.start, r.stop) for r in window)
        drawn = tuple((id(e.cut), e.colour, e.hued, e.width, e.opacity) for e in layers)
        key = (drawn, scale, bounds, pixels, palette, look.heat, borders, lobes)
        known = self._images.get(view)
        if known is None or known[0] != key:
            packed = paint(layers, scale, window, pixels, palette, look.heat, borders, lobes)
            image = image_of(packed)
            image.setDevicePixelRatio(frame.ratio)
            known = self._images[view] = key, image, packed
        return known[1]

    def _paint_cells(self, painter: QPainter, view: str, frame: Frame2D, faded: bool) -> None:
        """Flux as one colour per cell, or paper."""
        look, palette, window = self.session.display.look, self.stage.palette, frame.window
        corners = frame.cell_pixels(
            np.array([(window[0].start, window[1].stop), (window[0].stop, window[1].start)], float)
        )
        area = QRectF(QPointF(*corners[0]), QPointF(*corners[1]))
        main = self.stage.main(view)
        if main is None or (faded and look.heat == "off"):
            painter.fillRect(area, QColor(palette.paper))
            return
        packed = heat_colours(main, self.stage.scale(view), window, palette)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
        painter.drawImage(area, image_of(np.ascontiguousarray(packed.T[::-1])))
        if faded:
            veil = QColor(palette.paper)
            veil.setAlphaF(0.5)
            painter.fillRect(area, veil)

    def _paint_grid(self, painter: QPainter, frame: Frame2D) -> None:
        painter.setPen(pen(self.stage.palette.grid, 0.5))
        right, up = frame.window
        low, high = np.array([right.start, up.start]), np.array([right.stop, up.stop])
        for i in range(right.start, right.stop + 1):
            ends = frame.cell_pixels(np.array([(i, low[1]), (i, high[1])]))
            painter.drawLine(QPointF(*ends[0]), QPointF(*ends[1]))
        for j in range(up.start, up.stop + 1):
            ends = frame.cell_pixels(np.array([(low[0], j), (high[0], j)]))
            painter.drawLine(QPointF(*ends[0]), QPointF(*ends[1]))

    def _paint_levels(self, painter: QPainter, view: str, frame: Frame2D) -> None:
        """Bold lines where a merged field is read from another level on the other side."""
        shown = self.session.frame
        run = view in ("source", "target", "accumulated", "difference")
        if shown is None or shown.index is None or self.session.level is not None or not run:
            return
        index = frame.plane.cut(shown.index, frame.grid.dimension)
        right, up = frame.window
        painter.setPen(pen(self.stage.palette.level, 2.0))
        for i, j in np.argwhere(index[1:, :] != index[:-1, :]):
            if right.start <= i + 1 <= right.stop and up.start <= j < up.stop:
                ends = frame.cell_pixels(np.array([(i + 1, j), (i + 1, j + 1)]))
                painter.drawLine(QPointF(*ends[0]), QPointF(*ends[1]))
        for i, j in np.argwhere(index[:, 1:] != index[:, :-1]):
            if right.start <= i < right.stop and up.start <= j + 1 <= up.stop:
                ends = frame.cell_pixels(np.array([(i, j + 1), (i + 1, j + 1)]))
                painter.drawLine(QPointF(*ends[0]), QPointF(*ends[1]))

    def _paint_border(self, painter: QPainter, frame: Frame2D) -> None:
        nx, ny = frame.plane.shape(frame.grid)
        corners = frame.cell_pixels(np.array([(0, ny), (nx, 0)], float))
        painter.setPen(pen(self.stage.palette.level, 1.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(QRectF(QPointF(*corners[0]), QPointF(*corners[1])))

    def _paint_outlines(self, painter: QPainter, layer: Layer, view: str, frame: Frame2D) -> None:
        scale = self.stage.scale(view)
        size = frame.zoom / frame.ratio
        flip = np.array([size, -size])
        negative = QColor(self.stage.palette.negative)
        brushes, window = _brushes(layer), frame.window
        colours = layer.colours(window, self.stage.palette)
        for cell, positive, other in lobe_outlines(layer, scale, window):
            middle = frame.cell_pixels(np.array(cell) + 0.5)
            colour = QColor.fromRgb(
                int(colours[cell[0] - window[0].start, cell[1] - window[1].start])
            )
            for outline, ink, stripes in ((positive, colour, False), (other, negative, True)):
                if len(outline):
                    line, brush = brushes(ink, stripes)
                    painter.setPen(line)
                    painter.setBrush(brush)
                    painter.drawPolygon(polygon(middle + outline * flip))


def _brushes(layer: Layer) -> Callable[[QColor, bool], tuple[QPen, QBrush]]:
    """Pen and brush of a lobe by its colour: a line, or filled; negative light in stripes."""

    def make(colour: QColor, stripes: bool) -> tuple[QPen, QBrush]:
        ink = QColor(colour)
        ink.setAlphaF(layer.opacity)
        if layer.width:
            return QPen(ink, layer.width), QBrush(Qt.BrushStyle.NoBrush)
        if stripes:
            return QPen(ink, 1.0), QBrush(ink, Qt.BrushStyle.BDiagPattern)
        return QPen(Qt.PenStyle.NoPen), QBrush(ink)

    return make


def image_of(packed: Packed) -> QImage:
    """Packed pixels (height, width) as an image that shares their memory."""
    height, width = packed.shape
    return QImage(packed.data, width, height, 4 * width, QImage.Format.Format_RGB32)
