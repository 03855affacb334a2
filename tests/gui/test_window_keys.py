"""Keys: a command, or the control that has the focus."""

from __future__ import annotations

from conftest import settle
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QCheckBox

from gui.models.tools import Tool


def test_keys_reach_the_field_that_has_the_focus(make, qtbot):
    window = make("shelf")
    window.session.selection.set([("light", 0)])
    line = window.items_panel.controls["flux"].line
    line.setFocus()
    line.selectAll()
    qtbot.keyClicks(line, "12")
    qtbot.keyClick(line, Qt.Key.Key_Return)
    settle(window)
    assert window.session.scene.lights[0].flux == 12.0
    assert window.session.tool is Tool.SELECT
    window.views.canvases["accumulated"].setFocus()
    qtbot.keyClick(window.views.canvases["accumulated"], Qt.Key.Key_2)
    QApplication.processEvents()
    assert window.session.tool is Tool.OCCLUDE


def test_a_fresh_window_steps_on_the_first_key(make, qtbot):
    window = make("shelf")
    assert window.focusWidget() is window.views
    qtbot.keyClick(window.views, Qt.Key.Key_Right)
    settle(window)
    assert window.session.frame.iteration == 1


def test_enter_in_a_field_gives_the_keys_back_to_commands(make, qtbot):
    window = make("shelf")
    box = window.method_panel.bands
    box.setFocus()
    box.selectAll()
    qtbot.keyClicks(box, "3")
    qtbot.keyClick(box, Qt.Key.Key_Return)
    settle(window)
    assert window.session.choice.bands == 3
    assert window.focusWidget() is window.views
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_Right)
    settle(window)
    assert window.session.frame.iteration == 1


def test_a_click_on_a_control_leaves_the_keys_to_commands(make, qtbot):
    window = make("shelf")
    log = window.curves.findChildren(QCheckBox)[0]
    before = log.isChecked()
    qtbot.mouseClick(log, Qt.MouseButton.LeftButton, pos=QPoint(6, log.height() // 2))
    assert log.isChecked() is not before
    assert window.focusWidget() is window.views
    log.setFocus(Qt.FocusReason.TabFocusReason)
    assert window.focusWidget() is log


def test_controls_keep_the_keys_that_work_them_alone(make, qtbot):
    window = make("shelf")
    scheme = window.method_panel.propagator
    scheme.setFocus()
    qtbot.keyClick(scheme, Qt.Key.Key_Right)
    settle(window)
    assert window.session.frame.iteration == 1
    before = scheme.currentIndex()
    qtbot.keyClick(scheme, Qt.Key.Key_Down)
    settle(window)
    assert scheme.currentIndex() == before + 1
