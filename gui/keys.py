"""Who gets a key: the control with the focus, or the command that the key stands for."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDialog,
    QLineEdit,
    QPlainTextEdit,
    QTabBar,
    QWidget,
)

_UP_DOWN = {Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown}
_ENDS = {Qt.Key.Key_Home, Qt.Key.Key_End}
_SIDES = {Qt.Key.Key_Left, Qt.Key.Key_Right}
#: Keys that work a control while it has the focus; all others are commands.
_OWN_KEYS: tuple[tuple[type[QWidget], set[Qt.Key]], ...] = (
    (QAbstractButton, {Qt.Key.Key_Space}),
    (QComboBox, {Qt.Key.Key_Space} | _UP_DOWN | _ENDS),
    (QAbstractSlider, _UP_DOWN | _ENDS | _SIDES),
    (QTabBar, _SIDES),
    (QAbstractItemView, {Qt.Key.Key_Space} | _UP_DOWN | _ENDS | _SIDES),
)
_TYPING = (QLineEdit, QPlainTextEdit, QAbstractSpinBox)
#: A click works these, and leaves the focus where it was; Tab gives it to them.
_CLICKED = (QAbstractButton, QComboBox, QAbstractSlider)
_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class Keys(QObject):
    """Filters the keys of an application for `window`.

    Controls keep the keys that work them, text fields all plain ones. Enter in a field of the
    window ends the typing: the focus goes to `home`, and the next key is a command. Nor do clicks
    on buttons, lists and sliders take the keys away from commands.
    """

    def __init__(self, window: QWidget, home: QWidget) -> None:
        super().__init__(window)
        self.window, self.home = window, home
        self._application().installEventFilter(self)

    def stop(self) -> None:
        """Filter no more."""
        self._application().removeEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Polish and isinstance(watched, _CLICKED):
            # A panel may be polished before it is in the window; dialogs have no commands.
            if not isinstance(watched.window(), QDialog):
                watched.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            return False
        if not isinstance(event, QKeyEvent):
            return False
        focus = QApplication.focusWidget()
        if event.type() == QEvent.Type.ShortcutOverride and is_own_key(focus, event):
            event.accept()
            return True
        # On release: the press has ended the editing by then.
        if event.type() == QEvent.Type.KeyRelease and event.key() in _ENTER:
            self._go_home(focus)
        return False

    def _go_home(self, focus: QWidget | None) -> None:
        single = isinstance(focus, (QLineEdit, QAbstractSpinBox))
        if focus is not None and single and focus.window() is self.window:
            self.home.setFocus()

    @staticmethod
    def _application() -> QApplication:
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        return application


def is_own_key(focus: QWidget | None, event: QKeyEvent) -> bool:
    """Whether the control with the focus needs this key for itself."""
    if event.modifiers() & ~Qt.KeyboardModifier.ShiftModifier:
        return False
    if isinstance(focus, _TYPING):
        return event.key() != Qt.Key.Key_Escape
    return any(isinstance(focus, kind) and event.key() in keys for kind, keys in _OWN_KEYS)
