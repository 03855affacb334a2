"""Everything that asks the user or tells something in a window of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDialog, QFileDialog, QMessageBox

if TYPE_CHECKING:
    from gui.window import Window


class Dialogs:
    """Waits for answers. Tests replace single methods."""

    def __init__(self, window: Window) -> None:
        self.window = window

    def tell(self, title: str, text: str) -> None:
        box = QMessageBox(self.window)
        box.setWindowTitle(title)
        box.setText(f"<b>{title}</b>")
        box.setInformativeText(text)
        box.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.open()

    def fault(self, title: str, text: str, details: str) -> None:
        from gui.widgets.fault import FaultDialog

        FaultDialog(self.window, title, text, details).open()

    def sure(self, question: str) -> bool:
        answer = QMessageBox.question(self.window, "flatland", question)
        return answer == QMessageBox.StandardButton.Yes

    def ask_save(self, name: str) -> str:
        """What to do with unsaved changes: "save", "drop" or "stay"."""
        buttons = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self.window,
            "Unsaved changes",
            f"{name} has changes that are not saved.",
            buttons.Save | buttons.Discard | buttons.Cancel,
        )
        return {buttons.Save: "save", buttons.Discard: "drop"}.get(answer, "stay")

    def open_path(self, title: str, kinds: str) -> Path | None:
        name, _ = QFileDialog.getOpenFileName(self.window, title, self._directory(), kinds)
        return Path(name) if name else None

    def save_path(self, title: str, proposed: Path, kinds: str) -> Path | None:
        place = proposed if proposed.is_absolute() else Path(self._directory()) / proposed
        name, _ = QFileDialog.getSaveFileName(self.window, title, str(place), kinds)
        return Path(name) if name else None

    def _directory(self) -> str:
        path = self.window.session.document.origin.path
        return str(path.parent) if path is not None else str(Path.cwd())

    def gallery(self) -> str | None:
        from gui.widgets.gallery import Gallery

        dialog = Gallery(self.window, self.window.stage.palette)
        return dialog.chosen if dialog.exec() == QDialog.DialogCode.Accepted else None

    def edit_scene(self, text: str, check: Callable[[str], Any]) -> str | None:
        from gui.widgets.text_dialog import TextDialog

        dialog = TextDialog(self.window, text, check)
        return dialog.text if dialog.exec() == QDialog.DialogCode.Accepted else None

    def palette(self, actions: Mapping[str, QAction]) -> None:
        from gui.widgets.palette import CommandPalette

        CommandPalette(self.window, actions).open()

    def shortcuts(self) -> None:
        from gui.widgets.shortcut_sheet import ShortcutSheet

        ShortcutSheet(self.window).open()
