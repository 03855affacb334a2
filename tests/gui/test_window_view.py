"""The real window: views, scale, themes, palette, gallery."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import at_cell, do, settle, wait_until
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

from flatland.scene import builtin_names


def wheel(canvas, place, clicks):
    event = QWheelEvent(
        QPointF(place), QPointF(canvas.mapToGlobal(place)), QPoint(), QPoint(0, 120 * clicks),
        Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase,
        False,
    )  # fmt: skip
    QApplication.sendEvent(canvas, event)


def test_views_zoom_and_pan_together(make, qtbot):
    window = make()
    canvas, place = at_cell(window, 4, 4)
    cell = canvas.frame.cell_place(place.x(), place.y())
    wheel(canvas, place, 4)
    for other in window.views.canvases.values():
        assert other.camera is canvas.camera
    assert canvas.frame.cell_place(place.x(), place.y()) == pytest.approx(cell, abs=0.6)
    before = canvas.camera.centre
    qtbot.mousePress(canvas, Qt.MouseButton.MiddleButton, pos=place)
    canvas.mouseMoveEvent(_moved(canvas, place + QPoint(30, 0)))
    qtbot.mouseRelease(canvas, Qt.MouseButton.MiddleButton, pos=place + QPoint(30, 0))
    assert canvas.camera.centre[0] == pytest.approx(before[0] - 30 / canvas.camera.zoom)
    do(window, "fit")
    assert canvas.camera.fitted


def _moved(canvas, place):
    from PySide6.QtCore import QEvent
    from PySide6.QtGui import QMouseEvent

    return QMouseEvent(
        QEvent.Type.MouseMove, QPointF(place), QPointF(canvas.mapToGlobal(place)),
        Qt.MouseButton.NoButton, Qt.MouseButton.MiddleButton, Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip


def test_a_scale_set_by_hand_stays(make):
    window = make("shelf")
    do(window, "step_many")
    window.scale_bar.number.setText("0.25")
    window.scale_bar._typed()
    assert window.session.display.look.top == 0.25
    for command in ("step_many", "solve", "inject", "scale_kind", "reference"):
        do(window, command)
    window.session.document.load("fig5-one-light")
    settle(window)
    assert window.session.display.look.top == 0.25
    assert window.scale_bar.number.text() == "0.25"
    do(window, "fit_scale")
    do(window, "inject")
    assert window.scale_bar.fit.isChecked()
    top = window.stage.top("accumulated")
    assert window.scale_bar.number.text() == f"{top:.4g}"


def test_the_fitted_scale_follows_the_light(make):
    window = make("shelf")
    before = window.stage.top("accumulated")
    do(window, "step_many")
    assert window.stage.top("accumulated") > before


def test_views_come_and_go(make):
    window = make()
    do(window, "view:source")
    do(window, "view:target")
    assert window.session.display.look.views == ("accumulated",)
    do(window, "view:accumulated")
    assert window.session.display.look.views == ("accumulated",)
    do(window, "view:reference")
    assert window.session.exact is not None
    do(window, "one_view")
    assert window.session.display.look.views == ("accumulated",)
    do(window, "one_view")
    assert window.session.display.look.views == ("accumulated", "reference")
    assert window.views.canvases["reference"].isVisible()


@pytest.mark.parametrize("zoom", [0.25, 4, 9, 40, 128])
def test_every_zoom_draws_the_light(make, zoom):
    window = make("fig5-one-light")
    do(window, "step_many")
    window.camera._set((8.0, 4.0), zoom, False)
    canvas = window.views.canvases["accumulated"]
    image = canvas.grab().toImage().convertToFormat(canvas.grab().toImage().Format.Format_RGB32)
    do(window, "reset")
    dark = canvas.grab().toImage()
    colours = {
        image.pixel(x, y) for x in range(0, image.width(), 3) for y in range(0, image.height(), 3)
    }
    assert len(colours) > 4
    assert image != dark


def test_looks_change_the_picture(make):
    window = make("shelf")
    do(window, "step_many")
    canvas = window.views.canvases["accumulated"]
    seen = [canvas.grab().toImage()]
    for command in ("heat", "heat", "heat", "scale_kind", "larger", "layer:grid", "layer:occluders",
                    "layer:injected", "theme"):  # fmt: skip
        do(window, command)
        seen.append(canvas.grab().toImage())
    changed = [a != b for a, b in pairwise(seen)]
    assert all(changed)
    assert window.settings.theme == "dark"


def test_3d_scenes_are_looked_at_in_slices(make, room):
    window = make(room)
    do(window, "step_many")
    assert window.session.plane.axes == (0, 1)
    assert window.slice_bar.slice.isVisible()
    do(window, "slice_up")
    assert window.session.plane.layer == 3
    do(window, "slice_axis")
    assert window.session.plane.normal == 0
    assert window.session.plane.shape(window.session.scene.grid) == (5, 4)
    window.session.display.set(normal=2, layer=2)
    field = window.session.frame.accumulated
    layer = window.stage.main("accumulated")
    direction = np.array([[np.cos(0.3), np.sin(0.3), 0.0]])
    exact = field.evaluate(direction)[0][:, :, 2]
    from gui.render.tables import _evaluate

    drawn = layer.cells @ _evaluate(field.basis, (0, 1), np.array([0.3]))[0]
    np.testing.assert_allclose(drawn, exact, atol=1e-6)
    canvas, place = at_cell(window, 2, 2)
    window.session.selection.hover(canvas.frame.cell_at(place.x(), place.y()))
    assert window.session.selection.hovered == (2, 2, 2)
    window.inspector.refresh()
    assert "W/sr" in window.inspector.labels["Largest"].text()


def test_colours_are_shown_together_and_apart(make):
    window = make("cornell-2d")
    do(window, "step_many")
    assert window.slice_bar.channel.count() == 4
    together = window.stage.main("accumulated").flux
    window.slice_bar.channel.setCurrentIndex(2)
    settle(window)
    green = window.stage.main("accumulated").flux
    flux = window.session.frame.accumulated.scalar_flux()
    np.testing.assert_allclose(green, flux[1])
    np.testing.assert_allclose(together, flux.sum(axis=0))


def test_the_palette_finds_and_does(make, qtbot):
    from gui.widgets.palette import CommandPalette

    window = make("shelf")
    palette = CommandPalette(window, window.actions_by_name)
    palette.search("clear occ")
    assert palette.list.item(0).text().startswith("Edit: Clear occluders")
    palette.choose()
    assert window.session.scene.occluders == ()
    other = CommandPalette(window, window.actions_by_name)
    other.search("no such thing")
    assert other.list.count() == 0
    other.choose()
    window.controller.dialogs.palette(window.actions_by_name)
    QApplication.processEvents()
    QApplication.activePopupWidget().close()


def test_the_sheet_tells_all_keys(qtbot):
    from gui.actions import COMMANDS
    from gui.widgets.shortcut_sheet import ShortcutSheet

    sheet = ShortcutSheet(None)
    text = sheet.page.toPlainText()
    for command in COMMANDS:
        if command.keys:
            assert command.text in text
    sheet.close()


def test_the_gallery_shows_every_scene(make, answers, qtbot):
    from gui.render.colours import DARK
    from gui.widgets.gallery import Gallery

    window = make()
    gallery = Gallery(window, DARK)
    assert gallery.list.count() == len(builtin_names())
    wait_until(lambda: not gallery._waiting)
    assert not gallery.list.item(0).icon().isNull()
    gallery._take(gallery.list.item(1))
    assert gallery.chosen == builtin_names()[1]
    answers["gallery"] = "shelf"
    do(window, "gallery")
    assert window.session.document.origin.name == "shelf"


def test_the_layout_is_kept_and_reset(make):
    from gui.window import LAYOUT_VERSION

    window = make()
    window.docks["Cell"].hide()
    state = window.saveState(LAYOUT_VERSION)
    do(window, "reset_layout")
    assert window.docks["Cell"].isVisible()
    window._restore_docks(state)
    assert not window.docks["Cell"].isVisible()
    assert not window._restore_docks(state[:40])
