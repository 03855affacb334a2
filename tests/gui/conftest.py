"""The window under test: no display, no settings of the user, answers given in advance."""

import os
import sys
import time

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
# The window must not need a display, nor write into the tester's own folders.
os.environ.setdefault("QT_LOGGING_RULES", "qt.qpa.*=false")

HINT = (
    "the tests of the desktop need Qt's system libraries; on Debian and Ubuntu: apt-get install "
    "libegl1 libgl1 libxkbcommon0 libdbus-1-3 libfontconfig1 libglib2.0-0"
)
_ROOM = """
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


def pytest_configure(config):
    """One clear message instead of an error for every test."""
    try:
        import PySide6.QtWidgets  # noqa: F401
    except ImportError as error:
        pytest.exit(f"{HINT} ({error})", returncode=4)


@pytest.fixture
def room(tmp_path):
    """The path of a small scene in 3D."""
    path = tmp_path / "room.toml"
    path.write_text(_ROOM, encoding="utf-8")
    return str(path)


@pytest.fixture
def answers():
    """What the user would say in dialogs, by the name of the dialog."""
    return {"sure": True, "ask_save": "drop", "open_path": None, "save_path": None}


@pytest.fixture
def make(qtbot, answers, tmp_path):
    """Makes a window on a scene; closes it at the end."""
    from gui.application import make_window

    made = []

    def build(scene="fig5-one-light", shown=True):
        hook = sys.excepthook
        window = make_window(scene, bare=True, theme="light")
        sys.excepthook = hook  # so that an exception in a slot fails the test
        dialogs = window.controller.dialogs
        window.told = []
        dialogs.sure = lambda question: answers["sure"]
        dialogs.ask_save = lambda name: answers["ask_save"]
        dialogs.open_path = lambda title, kinds: answers["open_path"]
        dialogs.save_path = lambda title, proposed, kinds: answers["save_path"]
        dialogs.gallery = lambda: answers.get("gallery")
        dialogs.edit_scene = lambda text, check: answers.get("edit_scene")
        dialogs.tell = lambda title, text: window.told.append((title, text))
        dialogs.fault = lambda title, text, details: window.told.append((title, details))
        window.notices = []
        window.session.noticed.connect(window.notices.append)
        window.resize(1100, 760)
        made.append(window)
        if shown:
            window.show()
            window.session.begin()
            settle(window)
        return window

    yield build
    for window in made:
        window.shut_down()
        window.close()
        window.deleteLater()


def settle(window, seconds=60.0):
    """Let the worker finish, then the window draw."""
    from PySide6.QtWidgets import QApplication

    from gui.application import settle as wait

    assert wait(QApplication.instance(), window, seconds), "the window did not come to rest"


def wait_until(condition, seconds=20.0):
    """Run events until something holds."""
    from PySide6.QtWidgets import QApplication

    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "what was waited for did not happen"
        QApplication.processEvents()
        time.sleep(0.002)


def do(window, name):
    """Trigger a command as its key would."""
    window.actions_by_name[name].trigger()
    settle(window)


def at_cell(window, i, j, view="accumulated"):
    """The middle of a cell of the plane on a canvas, as a point for the mouse."""
    import numpy as np
    from PySide6.QtCore import QPoint

    canvas = window.views.canvases[view]
    x, y = canvas.frame.cell_pixels(np.array([i + 0.5, j + 0.5]))
    return canvas, QPoint(round(float(x)), round(float(y)))


def drag(qtbot, window, cells, button=None, modifier=None, view="accumulated"):
    """Press in the first cell, move over the others, release in the last."""
    from PySide6.QtCore import Qt

    button = button or Qt.MouseButton.LeftButton
    modifier = modifier or Qt.KeyboardModifier.NoModifier
    canvas, start = at_cell(window, *cells[0], view=view)
    qtbot.mousePress(canvas, button, modifier, start)
    for cell in cells[1:]:
        move(canvas, at_cell(window, *cell, view=view)[1], button, modifier)
    qtbot.mouseRelease(canvas, button, modifier, at_cell(window, *cells[-1], view=view)[1])
    settle(window)


def move(canvas, place, button, modifier):
    """A mouse move with a button held, which qtbot cannot send."""
    from PySide6.QtCore import QEvent, QPointF
    from PySide6.QtGui import QMouseEvent
    from PySide6.QtWidgets import QApplication

    where = QPointF(place)
    everywhere = QPointF(canvas.mapToGlobal(place))
    event = QMouseEvent(QEvent.Type.MouseMove, where, everywhere, button, button, modifier)
    QApplication.sendEvent(canvas, event)
