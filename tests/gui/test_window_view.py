"""The real window: views, scale, themes, palette, files and exports."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import at_cell, do, settle, wait_until
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent, QGuiApplication, QWheelEvent
from PySide6.QtWidgets import QApplication

from flatland.results import load_dataset
from flatland.scene import builtin_names, parse_scene

ROOM = """
title = "A small room"
[grid]
shape = [6, 5, 4]
[[light]]
kind = "cell"
cell = [1, 2, 2]
direction = [1.0, 0.2, 0.0]
flux = 1.0
[[occluder]]
kind = "box"
min = [3.0, 1.0, 1.0]
max = [4.0, 3.0, 3.0]
"""


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(ROOM, encoding="utf-8")
    return str(path)


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


def test_wrong_files_are_told_and_change_nothing(make, tmp_path, answers):
    window = make("shelf")
    before = window.session.document.text
    files = {
        "bad.toml": "[grid]\nshape = [0]\n",
        "syntax.toml": "[grid\n",
        "binary.toml": None,
        "empty.toml": "",
    }
    for name, text in files.items():
        path = tmp_path / name
        path.write_bytes(bytes(range(256)) if text is None else text.encode())
        answers["open_path"] = path
        do(window, "open")
        assert name in window.told[-1][1]
    answers["open_path"] = tmp_path / "missing.toml"
    do(window, "open")
    assert "neither a file" in window.told[-1][1]
    answers["open_path"] = tmp_path
    do(window, "open")
    assert len(window.told) == 6
    assert window.session.document.text == before


def test_save_reopen_and_recent(make, tmp_path, answers):
    window = make("shelf")
    do(window, "clear_occluders")
    answers["save_path"] = tmp_path / "mine"
    do(window, "save")
    assert not window.session.document.dirty
    saved = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    assert saved == window.session.document.text
    assert "# A strong light above" in saved
    do(window, "new")
    assert window.session.document.origin.path is None
    window.recent_menu.aboutToShow.emit()
    action = window.recent_menu.actions()[0]
    assert action.text().endswith("mine.toml")
    action.trigger()
    settle(window)
    assert window.session.document.origin.path == (tmp_path / "mine.toml").resolve()


def test_unsaved_changes_are_asked_about(make, answers):
    window = make("shelf")
    do(window, "clear_lights")
    answers["ask_save"] = "stay"
    assert not window.controller.open_scene("fig5-one-light")
    assert window.session.document.origin.name == "shelf"
    window.close()
    assert window.isVisible()
    answers["ask_save"] = "drop"
    assert window.controller.open_scene("fig5-one-light")


def test_a_file_dropped_on_the_window_is_opened(make, room):
    window = make()
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(room)])
    event = QDropEvent(
        QPointF(50, 50), Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton,
        Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    window.dropEvent(event)
    settle(window)
    assert window.session.scene.title == "A small room"


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_views_are_exported(make, tmp_path, answers, ending):
    window = make("fig5-one-light")
    do(window, "step_many")
    answers["save_path"] = tmp_path / f"view.{ending}"
    do(window, "export_view")
    content = answers["save_path"].read_bytes()
    start = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending]
    assert content.startswith(start)
    assert window.told == []
    if ending == "svg":
        assert content.count(b"<polygon") + content.count(b"<polyline") > 200
        assert b"<image" not in content


def test_exports_of_data_curves_and_animation(make, tmp_path, answers):
    from PIL import Image

    window = make("fig5-one-light")
    do(window, "step_many")
    answers["save_path"] = tmp_path / "run.nc"
    do(window, "export_data")
    stored = load_dataset(tmp_path / "run.nc")
    np.testing.assert_array_equal(
        stored["accumulated"].values, window.session.frame.accumulated.values
    )
    assert parse_scene(stored.attrs["scene"]) == window.session.scene
    for name in ("curves.csv", "curves.pdf"):
        answers["save_path"] = tmp_path / name
        do(window, "export_curves")
        assert (tmp_path / name).stat().st_size > 200
    answers["save_path"] = tmp_path / "run.gif"
    do(window, "export_animation")
    with Image.open(tmp_path / "run.gif") as animation:
        assert animation.n_frames == 11
    assert window.session.iteration == 10
    answers["save_path"] = tmp_path / "view.xyz"
    do(window, "export_view")
    assert "no known ending" in window.told[-1][1]
    answers["save_path"] = tmp_path / "no" / "\0bad.pdf"
    do(window, "export_view")
    assert len(window.told) == 2


def test_copies(make):
    window = make("shelf")
    do(window, "copy_scene")
    assert parse_scene(QGuiApplication.clipboard().text()) == window.session.scene
    do(window, "clear_occluders")
    do(window, "copy_command")
    text = QGuiApplication.clipboard().text()
    assert text.startswith("cat > scene.toml")
    assert "flatland run scene.toml" in text
    do(window, "copy_picture")
    assert not QGuiApplication.clipboard().image().isNull()


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


def test_an_exception_becomes_a_message_and_the_window_stays(make, monkeypatch):
    import sys

    from gui.application import install_hook

    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    window = make("shelf")
    install_hook(window)
    error = RuntimeError("a test")
    sys.excepthook(RuntimeError, error, None)
    assert window.told[-1][0] == "A fault of flatland"
    assert "a test" in window.told[-1][1]
    assert window.isVisible()


def test_a_fault_in_the_worker_is_told_and_the_worker_goes_on(make, monkeypatch):
    window = make("shelf")

    def broken(*_, **__):
        raise RuntimeError("broken on purpose")

    monkeypatch.setattr(type(window.engine), "step", broken)
    do(window, "step")
    assert "broken on purpose" in window.told[-1][1]
    monkeypatch.undo()
    do(window, "step")
    assert window.session.iteration == 1


def test_the_fault_dialog_copies_its_details(qtbot):
    from gui.widgets.fault import FaultDialog

    dialog = FaultDialog(None, "Title", "text", "Traceback: details")
    dialog.copy.click()
    assert "Traceback: details" in QGuiApplication.clipboard().text()
    dialog.reject()
