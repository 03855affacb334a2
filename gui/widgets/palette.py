"""Find a command by its name, and do it."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import QDialog, QLineEdit, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from gui.actions import COMMANDS


class CommandPalette(QDialog):
    """Words in any order; Up and Down choose, Enter does it."""

    def __init__(self, parent: QWidget | None, actions: Mapping[str, QAction]) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.actions_by_name = actions
        self.line = QLineEdit()
        self.line.setPlaceholderText("Type what you want to do")
        self.line.textChanged.connect(self.search)
        self.line.returnPressed.connect(self.choose)
        self.line.installEventFilter(self)
        self.list = QListWidget()
        self.list.itemActivated.connect(lambda _: self.choose())
        self.list.itemClicked.connect(lambda _: self.choose())
        column = QVBoxLayout(self)
        column.addWidget(self.line)
        column.addWidget(self.list)
        self.resize(480, 360)
        if parent is not None:
            middle = parent.mapToGlobal(parent.rect().center())
            self.move(middle.x() - 240, parent.mapToGlobal(parent.rect().topLeft()).y() + 80)
        self.search("")
        self.line.setFocus()

    def search(self, text: str) -> None:
        """List the commands that hold all words; those that begin with the text first."""
        words = text.lower().split()
        found = []
        for command in COMMANDS:
            name = f"{command.name}:{command.argument}" if command.argument else command.name
            action = self.actions_by_name[name]
            place = f"{command.menu}: {action.text()}"
            whole = f"{place} {command.tip}".lower()
            if action.isEnabled() and all(word in whole for word in words):
                first = action.text().lower().startswith(text.lower())
                titled = all(word in place.lower() for word in words)
                found.append((not first, not titled, place, name, command.tip))
        self.list.clear()
        for _, _, place, name, tip in sorted(found, key=lambda each: each[:2]):
            keys = self.actions_by_name[name].shortcut().toString()
            item = QListWidgetItem(f"{place}    {keys}" if keys else place)
            item.setData(Qt.ItemDataRole.UserRole, name)
            item.setToolTip(tip)
            self.list.addItem(item)
        self.list.setCurrentRow(0)

    def choose(self) -> None:
        item = self.list.currentItem()
        self.close()
        if item is not None:
            self.actions_by_name[item.data(Qt.ItemDataRole.UserRole)].trigger()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            change = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1}.get(Qt.Key(event.key()), 0)
            if change and self.list.count():
                row = (self.list.currentRow() + change) % self.list.count()
                self.list.setCurrentRow(row)
                return True
        return super().eventFilter(watched, event)
