"""All keys on one page."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QTextBrowser, QVBoxLayout, QWidget

from gui.actions import COMMANDS, MENUS

#: What the mouse does, for the sheet and the documentation.
MOUSE = (
    ("Left button", "the tool"),
    ("Right button", "erase"),
    ("Middle button, or tool Pan", "move the view"),
    ("Wheel", "zoom at the mouse"),
    ("Ctrl while drawing or dragging", "snap to corners and middles of cells"),
    ("Shift while drawing or dragging", "keep to multiples of 45 degrees"),
    ("Click on a cell, tool Select", "pin it in the Cell dock"),
    ("Double-click on a view's title", "this view alone, or all again"),
)


def sheet_html() -> str:
    """The page."""
    parts = []
    for menu in MENUS:
        rows = [
            f"<tr><td>{_keys(command.keys)}</td><td>{command.text}</td><td>{command.tip}</td></tr>"
            for command in COMMANDS
            if command.menu == menu and command.keys
        ]
        parts.append(f"<h3>{menu}</h3><table cellpadding='3'>{''.join(rows)}</table>")
    rows = [f"<tr><td><b>{what}</b></td><td>{does}</td></tr>" for what, does in MOUSE]
    parts.append(f"<h3>Mouse</h3><table cellpadding='3'>{''.join(rows)}</table>")
    return "".join(parts)


def _keys(keys: tuple[str, ...]) -> str:
    shown = [QKeySequence(each).toString(QKeySequence.SequenceFormat.NativeText) for each in keys]
    return "<b>" + ", ".join(text.replace("<", "&lt;") for text in shown) + "</b>"


class ShortcutSheet(QDialog):
    """A page to read; Esc closes it."""

    def __init__(self, parent: QWidget | None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Shortcuts")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.page = QTextBrowser()
        self.page.setHtml(sheet_html())
        self.page.setTextInteractionFlags(Qt.TextInteractionFlag.TextBrowserInteraction)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(self.page)
        column.addWidget(buttons)
        self.resize(680, 640)
