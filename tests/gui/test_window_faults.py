"""Faults become messages, and the window stays."""

from __future__ import annotations

from conftest import do
from PySide6.QtGui import QGuiApplication


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
