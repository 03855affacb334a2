"""What all commands share: the window, and messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flatland.errors import FlatlandError
from gui.dialogs import Dialogs

if TYPE_CHECKING:
    from gui.models.session import Session
    from gui.undo import Editor
    from gui.window import Window


class Commands:
    """Base of the groups of commands. dialogs: everything that waits for an answer."""

    def __init__(self, window: Window) -> None:
        self.window = window
        self.dialogs = Dialogs(window)

    @property
    def session(self) -> Session:
        return self.window.session

    @property
    def editor(self) -> Editor:
        return self.window.editor

    def say(self, text: str) -> None:
        """A message in the status bar."""
        self.session.noticed.emit(text)

    def edit_text(
        self, label: str, text: str, selected: tuple[tuple[str, int], ...] | None = None
    ) -> bool:
        """Edit the scene, or say why not."""
        try:
            return self.editor.edit_text(label, text, selected)
        except FlatlandError as error:
            self.say(str(error))
            return False
