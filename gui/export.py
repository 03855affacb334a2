"""Views and curves as files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import (
    QBuffer,
    QByteArray,
    QIODevice,
    QMarginsF,
    QPoint,
    QRectF,
    QSize,
    QSizeF,
    Qt,
)
from PySide6.QtGui import QColor, QFont, QImage, QPageLayout, QPageSize, QPainter, QPdfWriter
from PySide6.QtSvg import QSvgGenerator

from flatland.errors import bad_input
from gui.models.engine import Engine
from gui.models.frame import Frame
from gui.models.jobs import Cancelled, Job
from gui.models.measures import ERRORS
from gui.models.storage import store_bytes
from gui.models.track import ENERGY, Row, Track
from gui.widgets.geometry import Frame2D
from gui.widgets.view_area import view_title

if TYPE_CHECKING:
    from gui.window import Window

#: Endings of pictures.
FORMATS = (".pdf", ".svg", ".png")
#: Side of a cell in a picture [logical pixels], and the largest side of a picture.
_CELL, _MOST = 24.0, 6000.0
_TITLE, _GAP = 22.0, 10.0
#: Frames of an animation at most, and how long each is shown [ms].
_FRAMES, _SHOWN = 120, 80


def save_views(window: Window, path: Path) -> Path:
    """All shown views in a row, as PDF, SVG or PNG by the file's ending.

    PDF and SVG hold outlines, not pixels. Raises InputError for another ending, ResultFileError.
    """
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise bad_input("file", str(path), "has no known ending", FORMATS)
    if ending == ".png":
        return store_bytes(path, png_bytes(picture_of(window, 2.0)))
    return store_bytes(path, _vector(window, ending))


def png_bytes(image: QImage) -> bytes:
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    image.save(buffer, "PNG")  # type: ignore[call-overload]
    return bytes(data.data())


def picture_of(window: Window, ratio: float = 1.0) -> QImage:
    """All shown views in a row, as pixels."""
    layout = _Layout(window, ratio)
    image = QImage(
        round(layout.width * ratio), round(layout.height * ratio), QImage.Format.Format_RGB32
    )
    image.setDevicePixelRatio(ratio)
    painter = QPainter(image)
    layout.paint(painter, vector=False)
    painter.end()
    return image


def _vector(window: Window, ending: str) -> bytes:
    layout = _Layout(window, 1.0)
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    size = QSize(round(layout.width), round(layout.height))
    device: QPdfWriter | QSvgGenerator
    if ending == ".pdf":
        device = QPdfWriter(buffer)
        device.setTitle(window.session.document.title)
        device.setPageSize(QPageSize(QSizeF(size) * 0.75, QPageSize.Unit.Point))
        device.setPageMargins(QMarginsF(0, 0, 0, 0), QPageLayout.Unit.Point)
        device.setResolution(960)
    else:
        device = QSvgGenerator()
        device.setOutputDevice(buffer)
        device.setSize(size)
        device.setViewBox(QRectF(0, 0, size.width(), size.height()))
        device.setTitle(window.session.document.title)
    painter = QPainter(device)
    if ending == ".pdf":
        painter.scale(10, 10)
    layout.paint(painter, vector=True)
    painter.end()
    return bytes(data.data())


class _Layout:
    """Where the views stand on a picture."""

    def __init__(self, window: Window, ratio: float) -> None:
        self.window, self.ratio = window, ratio
        session = window.session
        self.views = session.display.look.views
        self.shape = session.plane.shape(session.scene.grid)
        room = (_MOST - 60) / max(self.shape[0] * len(self.views), self.shape[1])
        cell = min(_CELL, room)
        # Whole device pixels a cell; below one, cells of a map share them.
        self.zoom = max(1.0, np.floor(cell * ratio)) if cell * ratio >= 1 else cell * ratio
        self.side = (self.shape[0] * self.zoom / ratio, self.shape[1] * self.zoom / ratio)
        self.width = len(self.views) * (self.side[0] + _GAP) + _GAP
        self.height = self.side[1] + _TITLE + _GAP

    def paint(self, painter: QPainter, vector: bool) -> None:
        session, palette = self.window.session, self.window.stage.palette
        painter.fillRect(QRectF(0, 0, self.width, self.height), QColor(palette.paper))
        font = QFont(painter.font())
        font.setPixelSize(12)
        painter.setFont(font)
        for index, view in enumerate(self.views):
            left = _GAP + index * (self.side[0] + _GAP)
            painter.setPen(QColor(palette.ink))
            box = QRectF(left, 0, self.side[0], _TITLE)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, view_title(view, session))
            painter.save()
            painter.translate(QPoint(0, 0))
            painter.setClipRect(QRectF(left - 3, _TITLE - 3, self.side[0] + 6, self.side[1] + 6))
            frame = Frame2D(
                session.scene.grid,
                session.plane,
                self.zoom,
                round(left * self.ratio),
                round((_TITLE + self.side[1]) * self.ratio),
                self.width * self.ratio,
                self.height * self.ratio,
                self.ratio,
            )
            self.window.painter.paint(painter, view, frame, vector)
            painter.restore()


class _Collector:
    """A watch that keeps the last frame."""

    def __init__(self) -> None:
        self.frame: Frame | None = None

    def cancelled(self) -> bool:
        return False

    def sleep(self, seconds: float) -> None:
        return

    def publish(self, frame: Frame, rows: list[Row]) -> None:
        self.frame = frame

    def progress(self, done: int, total: int) -> None:
        return

    def notice(self, text: str) -> None:
        return


def save_animation(window: Window, path: Path) -> Path:
    """The iterations so far, evenly picked, as an animated GIF; the scale stays what it is now.

    Runs the method anew, beside the run on show. Raises InputError, ResultFileError.
    """
    from PIL import Image

    if path.suffix.lower() != ".gif":
        raise bad_input("file", str(path), "must be an animation", (".gif",))
    session, last = window.session, window.session.last_iteration
    if not session.choice.steps or last == 0:
        raise bad_input("iterations", last, "there is nothing to animate yet: run some steps")
    kept, top = session.frame, window.stage.top("accumulated")
    look = session.display.look
    engine, watch = Engine(), _Collector()
    wanted = sorted({round(i) for i in np.linspace(0, last, min(last + 1, _FRAMES))})
    images: list[Image.Image] = []
    try:
        session.display.look = replace(look, top=top)
        engine.perform(Job("inject", session.scene, session.choice), watch)
        for iteration in wanted:
            count = iteration - (watch.frame.iteration if watch.frame else 0)
            if count:
                job = Job("step", session.scene, session.choice, arguments={"count": count})
                engine.perform(job, watch)
            session.frame = watch.frame
            with io.BytesIO(png_bytes(picture_of(window))) as data:
                images.append(Image.open(data).convert("P", palette=Image.Palette.ADAPTIVE))
    except Cancelled:
        pass
    finally:
        session.frame, session.display.look = kept, look
    content = io.BytesIO()
    images[0].save(
        content, format="GIF", save_all=True, append_images=images[1:], duration=_SHOWN, loop=0
    )
    return store_bytes(path, content.getvalue())


def save_curves(tracks: Sequence[Track], path: Path) -> Path:
    """Energy and errors over iterations in the project's figure style; PDF, PNG or SVG."""
    from matplotlib.figure import Figure

    from studies.style import PAGE, figure_style, save_figure

    with figure_style():
        figure = Figure(figsize=(PAGE, 0.42 * PAGE), layout="constrained")
        energy, errors = figure.subplots(1, 2)
        for axes, names in ((energy, list(ENERGY)), (errors, list(ERRORS))):
            for number, track in enumerate(tracks):
                for place, name in enumerate(names):
                    x, y = track.series(name)
                    if x and any(y):
                        label = f"{name.replace('_', ' ')}"
                        label += f" ({track.label})" if len(tracks) > 1 else ""
                        axes.plot(
                            x,
                            y,
                            f"C{place}",
                            linestyle=("-", "--", "-.", ":")[number % 4],
                            label=label,
                        )
            axes.set_xlabel("iteration")
            if axes.lines:
                axes.legend()
        energy.set_ylabel("flux [W]")
        errors.set_ylabel("error")
        if errors.lines:
            errors.set_yscale("log")
        return save_figure(figure, path)
