"""The scene as text, checked while it is typed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QTimer
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLabel,
    QPlainTextEdit,
    QVBoxLayout,
    QWidget,
)


class TextDialog(QDialog):
    """An editor of TOML; only a valid scene can be taken."""

    def __init__(self, parent: QWidget | None, text: str, check: Callable[[str], Any]) -> None:
        super().__init__(parent)
        self.setWindowTitle("Scene as text")
        self._check = check
        self.view = QPlainTextEdit(text)
        self.view.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.problems = QLabel()
        self.problems.setWordWrap(True)
        self.problems.setStyleSheet("color: #d5331f")
        buttons = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(buttons.Ok | buttons.Cancel)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(self.view, 1)
        column.addWidget(self.problems)
        column.addWidget(self.buttons)
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.setInterval(150)
        self._later.timeout.connect(self.check)
        self.view.textChanged.connect(self._later.start)
        self.resize(640, 620)

    @property
    def text(self) -> str:
        return self.view.toPlainText()

    def check(self) -> bool:
        """Show what is wrong; whether nothing is."""
        problem = ""
        try:
            self._check(self.text)
        except ValueError as error:
            problem = "\n".join(str(error).splitlines()[:6])
        self.problems.setText(problem)
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setEnabled(not problem)
        return not problem

    def accept(self) -> None:
        if self.check():
            super().accept()
