"""Scenes and pictures in files: opened, saved, dropped, exported and copied."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import do, settle
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent, QGuiApplication

from flatland.results import load_dataset
from flatland.scene import parse_scene


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
