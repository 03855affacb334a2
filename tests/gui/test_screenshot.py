"""`flatland-gui SCENE --screenshot FILE`, as a user would call it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from PySide6.QtGui import QImage

from flatland.errors import FlatlandError
from gui import system_libraries
from gui.application import _run


def run_gui(*arguments, platform=None):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment.pop("QT_QPA_PLATFORM", None)
    if platform:
        environment["QT_QPA_PLATFORM"] = platform
    return subprocess.run(
        [sys.executable, "-m", "gui", *arguments], env=environment, capture_output=True, text=True,
        timeout=180, check=False,
    )  # fmt: skip


def test_a_picture_without_a_display(tmp_path):
    path = tmp_path / "shelf.png"
    process = run_gui("shelf", "--screenshot", str(path), "--iterations", "8", "--size", "1200x700")
    assert process.returncode == 0, process.stderr
    image = QImage(str(path))
    assert (image.width(), image.height()) == (1200, 700)


def test_a_window_without_a_display_says_what_works():
    process = run_gui("shelf")
    assert process.returncode == 1
    assert "--screenshot" in process.stderr


def test_a_library_that_is_missing_for_windows_is_named(monkeypatch, tmp_path):
    """As a fresh Debian without libxcb-cursor0: Qt's plugin does not load, and Qt would abort."""
    plugin = tmp_path / "libqxcb.so"
    plugin.write_text("no library")
    assert system_libraries.missing_for(tmp_path / "none") == ""
    monkeypatch.setattr(system_libraries, "_x11_plugin", lambda: plugin)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("QT_QPA_PLATFORM", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", ":1")
    with pytest.raises(FlatlandError, match=r"libqxcb\.so.*apt-get install libxcb-cursor0"):
        system_libraries.require_display()


@pytest.mark.parametrize(
    "arguments",
    [
        ("no-such-scene", "--screenshot", "a.png"),
        ("shelf", "--screenshot", "a.bmp"),
        ("shelf", "--screenshot", "a.png", "--size", "12"),
        ("shelf", "--screenshot", "a.png", "--size", "99999x10"),
        ("shelf", "--screenshot", "a.png", "--propagator", "nonsense"),
        ("shelf", "--screenshot", "a.png", "--propagator", "dom26"),
        ("shelf", "--screenshot", "a.png", "--option", "flux=nonsense"),
        ("shelf", "--screenshot", "a.png", "--bands", "0"),
        ("shelf", "--screenshot", "a.png", "--levels", "99"),
        ("shelf", "--screenshot", "a.png", "--views", "left"),
        ("shelf", "--screenshot", "a.png", "--theme", "pink"),
        ("shelf", "--nonsense"),
    ],
)
def test_bad_input_is_refused_with_a_message(arguments, capsys, qapp, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert _run(list(arguments)) == 2
    assert capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_fails(capsys, qapp, tmp_path):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    arguments = ["shelf", "--screenshot", str(tmp_path / "file" / "a.png")]
    assert _run(arguments) == 1
    assert "cannot be written" in capsys.readouterr().err
