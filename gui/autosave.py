"""Keeps the unsaved scene a moment after each edit, and offers what a crash left behind."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer

from gui.models.recovery import Lost, Recovery

if TYPE_CHECKING:
    from gui.window import Window

#: Rest after the last edit before the scene is kept aside [ms].
DELAY = 1500


class AutoSave(QObject):
    """Runs only after edits: an idle window does nothing."""

    def __init__(self, window: Window, directory: Path | None) -> None:
        super().__init__(window)
        self.window = window
        self.recovery = Recovery(window.session.document, directory)
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.setInterval(DELAY)
        self._later.timeout.connect(self.recovery.keep)
        window.session.document.changed.connect(self._later.start)

    def forget(self) -> None:
        self._later.stop()
        self.recovery.forget()

    def close(self) -> None:
        """The window closes as it should: nothing to recover."""
        self.forget()
        self.window.session.document.changed.disconnect(self._later.start)

    def offer(self) -> bool:
        """Ask about a lost scene, if there is one; whether it was taken back."""
        for lost in self.recovery.lost():
            wanted = self.window.controller.dialogs.sure(
                f"flatland ended with unsaved changes in {lost.origin.name}. Take them back?"
            )
            lost.file.unlink(missing_ok=True)
            if wanted:
                return self._take(lost)
        return False

    def _take(self, lost: Lost) -> bool:
        try:
            self.window.session.document.replace(lost.text, lost.origin, saved=False)
        except ValueError as error:
            self.window.controller.dialogs.tell("The lost scene cannot be read", str(error))
            return False
        self.window.camera.refit()
        self.window.views.arrange()
        return True
