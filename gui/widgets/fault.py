"""A fault of the program, told with all that helps to mend it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLabel,
    QPlainTextEdit,
    QVBoxLayout,
    QWidget,
)


class FaultDialog(QDialog):
    """Text, details, and a button that copies both. The window stays, the scene with it."""

    def __init__(self, parent: QWidget | None, title: str, text: str, details: str) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        from flatland.results import versions

        known = ", ".join(f"{name} {number}" for name, number in versions().items())
        self.report = f"{text}\n\n{details}\n{known}\n"
        label = QLabel(f"{text}\n\nNothing is lost: scene and window are as they were.")
        label.setWordWrap(True)
        view = QPlainTextEdit(self.report)
        view.setReadOnly(True)
        view.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.copy = buttons.addButton("Copy details", QDialogButtonBox.ButtonRole.ActionRole)
        self.copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(self.report))
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        for widget in (label, view, buttons):
            column.addWidget(widget)
        self.resize(640, 360)
