"""Lights, occluders, selection and strokes over the cells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPen, QPolygonF

from flatland.errors import FlatlandError
from flatland.harmonics import basis_for
from flatland.injection import inject
from flatland.scene import Scene
from gui.models.session import Session
from gui.models.shapes import anchor_of, handles_of, outline_of
from gui.models.toml_text import tables_of
from gui.render.colours import Palette
from gui.widgets.geometry import Frame2D

#: Half the side of a handle [logical pixels].
HANDLE = 4.5


def pen(colour: str, width: float, dashed: bool = False) -> QPen:
    line = QPen(QColor(colour), width)
    line.setCapStyle(Qt.PenCapStyle.FlatCap)
    line.setJoinStyle(Qt.PenJoinStyle.MiterJoin)
    if dashed:
        line.setDashPattern([4, 3])
    return line


def polygon(points: NDArray[np.float64]) -> QPolygonF:
    return QPolygonF([QPointF(float(x), float(y)) for x, y in points])


class SceneLayer:
    """Tables of the scene's text, read once per text."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._text: str | None = None
        self._tables: dict[str, Any] = {}
        self._injected: tuple[Scene, NDArray[np.float64]] | None = None

    @property
    def tables(self) -> dict[str, list[dict[str, Any]]]:
        if self._text != self.session.document.text:
            self._text = self.session.document.text
            self._tables = tables_of(self._text)
        return self._tables

    def items(self) -> list[tuple[tuple[str, int], dict[str, Any]]]:
        """Every item with its place, occluders first."""
        return [
            ((name, i), table)
            for name in ("occluder", "light")
            for i, table in enumerate(self.tables.get(name, []))
        ]

    def injected(self) -> NDArray[np.float64]:
        """Flux and net flux (1 + dimension, *shape) of the cells that lights put light into."""
        scene = self.session.scene
        if self._injected is None or self._injected[0] is not scene:
            dimension = scene.grid.dimension
            try:
                field = inject(scene, basis_for(dimension, 2))
                flux = grey_sum(field.scalar_flux(), field.coloured)[None]
                net = grey_sum(field.net_flux(), field.coloured)
                values = np.concatenate([flux, net])
            except FlatlandError:
                values = np.zeros((1 + dimension, *scene.grid.shape))
            self._injected = scene, values
        return self._injected[1]


def grey_sum(values: NDArray[np.float64], coloured: bool) -> NDArray[np.float64]:
    return np.asarray(values.sum(axis=0)) if coloured else values


def paint_items(
    painter: QPainter, layer: SceneLayer, frame: Frame2D, palette: Palette, layers: tuple[str, ...]
) -> None:
    """All lights and occluders that the display shows."""
    for (name, _), table in layer.items():
        if f"{name}s" in layers:
            paint_item(painter, name, table, frame, palette)
    if "injected" in layers:
        _paint_injected(painter, layer, frame, palette)


def paint_item(
    painter: QPainter,
    name: str,
    table: Mapping[str, Any],
    frame: Frame2D,
    palette: Palette,
    ghost: bool = False,
) -> None:
    """One item. ghost: not there yet, dashed."""
    grid, plane = frame.grid, frame.plane
    outline = outline_of(name, table, grid, plane)
    faint = _apart(table, frame)
    painter.setOpacity(0.25 if faint else 1.0)
    colour = palette.ink if name == "occluder" else palette.light
    width = min(max(0.14 * frame.zoom / frame.ratio, 1.6), 5.0)
    painter.setPen(pen(colour, width, ghost))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    small = table.get("kind") in ("cell", "point")
    if small:
        painter.setPen(pen(colour, max(1.2, 0.6 * width), ghost))
    for line in outline.lines:
        points = polygon(frame.pixels(line))
        if outline.closed:
            if name == "occluder":
                inside = QColor(colour)
                inside.setAlphaF(0.22)
                painter.setBrush(QBrush(inside))
            if table.get("kind") == "point":
                painter.drawEllipse(points.boundingRect())
            else:
                painter.drawPolygon(points)
            painter.setBrush(Qt.BrushStyle.NoBrush)
        else:
            painter.drawPolyline(points)
    if name == "light":
        _paint_direction(painter, table, frame, palette, ghost)
    painter.setOpacity(1.0)


def _apart(table: Mapping[str, Any], frame: Frame2D) -> bool:
    """Whether a 3D item lies outside of the layer that is looked at."""
    plane, grid = frame.plane, frame.grid
    if plane.normal is None:
        return False
    low = grid.origin[plane.normal] + plane.layer * grid.spacing
    high = low + grid.spacing
    if "cell" in table:
        return bool(table["cell"][plane.normal] != plane.layer)
    values = [table[key] for key in ("min", "max", "position", "start", "end") if key in table]
    values += list(table.get("vertices", []))
    places = [value[plane.normal] for value in values if len(value) > plane.normal]
    return bool(places) and (max(places) < low - 1e-9 or min(places) > high + 1e-9)


def _paint_direction(
    painter: QPainter, table: Mapping[str, Any], frame: Frame2D, palette: Palette, ghost: bool
) -> None:
    """An arrow along a light's direction; of an area light, to its front."""
    grid, plane = frame.grid, frame.plane
    start = anchor_of("light", table, grid, plane)
    vector = table.get("direction")
    if vector is not None:
        heading = plane.project(np.array(vector, float))
    elif {"start", "end"} <= table.keys():
        along = plane.project(np.subtract(table["end"], table["start"]).astype(float))
        heading = np.array([-along[1], along[0]])
    else:
        return
    size = float(np.hypot(*heading))
    if size == 0:
        return
    tip = frame.pixels(start + heading / size * grid.spacing * 1.1)
    arrow(painter, frame.pixels(start), tip, pen(palette.light, 1.6, ghost))


def arrow(
    painter: QPainter, start: NDArray[np.float64], tip: NDArray[np.float64], line: QPen
) -> None:
    """A line with a head."""
    along = tip - start
    size = float(np.hypot(*along))
    if size < 3:
        return
    along = along / size
    side = np.array([-along[1], along[0]])
    head = min(6.0, 0.6 * size)
    painter.setPen(line)
    painter.drawLine(QPointF(*start), QPointF(*tip))
    wings = [tip - head * along + 0.5 * head * side, tip, tip - head * along - 0.5 * head * side]
    painter.drawPolyline(polygon(np.array(wings)))


def _paint_injected(painter: QPainter, layer: SceneLayer, frame: Frame2D, palette: Palette) -> None:
    """A dot in every cell that got light, and where its light goes on the whole."""
    plane, dimension = frame.plane, frame.grid.dimension
    cut = np.asarray(plane.cut(layer.injected(), dimension), np.float64)
    right, up = frame.window
    flux, net = cut[0][right, up], plane.project(np.moveaxis(cut[1:][:, right, up], 0, -1))
    size = 0.12 * frame.zoom / frame.ratio
    if size < 0.5:
        return
    painter.setBrush(QColor(palette.light))
    for i, j in np.argwhere(np.abs(flux) > 1e-12 * max(float(np.abs(cut[0]).max()), 1e-300)):
        at = frame.cell_pixels(np.array([i + right.start + 0.5, j + up.start + 0.5]))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.drawEllipse(QPointF(*at), size, size)
        length = float(np.hypot(*net[i, j]))
        if length > 0.05 * abs(flux[i, j]):
            tip = at + net[i, j] / length * np.array([1, -1]) * 0.45 * frame.zoom / frame.ratio
            arrow(painter, at, tip, pen(palette.light, 1.2))


def paint_selection(painter: QPainter, layer: SceneLayer, frame: Frame2D, palette: Palette) -> None:
    """A dashed line round what is selected, and its handles."""
    tables = layer.tables
    for name, index in layer.session.selection.items:
        entries = tables.get(name, [])
        if index >= len(entries):
            continue
        outline = outline_of(name, entries[index], frame.grid, frame.plane)
        painter.setPen(pen(palette.selected, 1.4, True))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for line in outline.lines:
            points = polygon(frame.pixels(line))
            painter.drawPolygon(points) if outline.closed else painter.drawPolyline(points)
        painter.setPen(pen(palette.selected, 1.4))
        painter.setBrush(QColor(palette.paper))
        for handle in handles_of(name, entries[index], frame.grid, frame.plane):
            x, y = frame.pixels(np.array(handle.at))
            if handle.kind == "direction":
                painter.drawEllipse(QPointF(x, y), HANDLE, HANDLE)
            else:
                painter.drawRect(QRectF(x - HANDLE, y - HANDLE, 2 * HANDLE, 2 * HANDLE))
