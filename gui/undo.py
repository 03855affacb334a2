"""Undo and redo: every edit of scene or method is one command on a stack."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject
from PySide6.QtGui import QUndoCommand, QUndoStack

from gui.models.choice import Choice
from gui.models.session import Session
from gui.models.shapes import Place


@dataclass(frozen=True)
class State:
    """What an edit changes."""

    text: str
    choice: Choice
    selected: tuple[Place, ...] = ()


class EditCommand(QUndoCommand):
    """From one state to another. Edits of the same thing in a row, by its key, become one."""

    def __init__(
        self, session: Session, label: str, before: State, after: State, key: str = ""
    ) -> None:
        super().__init__(label)
        self.session, self.before, self.after, self.key = session, before, after, key

    def id(self) -> int:
        return 1 if self.key else -1

    def mergeWith(self, other: QUndoCommand) -> bool:  # noqa: N802
        if not isinstance(other, EditCommand) or other.key != self.key:
            return False
        self.after = other.after
        return True

    def redo(self) -> None:
        self._go_to(self.after)

    def undo(self) -> None:
        self._go_to(self.before)

    def _go_to(self, state: State) -> None:
        session = self.session
        session.document.set_text(state.text)
        session.choose(state.choice)
        session.selection.set(state.selected)


class Editor:
    """The one door for edits: checks them first, so that a bad one changes nothing."""

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        self.session = session
        self.stack = QUndoStack(parent)

    @property
    def state(self) -> State:
        session = self.session
        return State(session.document.text, session.choice, session.selection.items)

    def edit_text(
        self, label: str, text: str, selected: tuple[Place, ...] | None = None, key: str = ""
    ) -> bool:
        """A new text of the scene; whether anything changed. Raises SceneError."""
        before = self.state
        if text == before.text:
            return False
        self.session.document.parse(text)
        kept = before.selected if selected is None else selected
        after = State(text, before.choice, kept)
        self.stack.push(EditCommand(self.session, label, before, after, key))
        return True

    def edit_choice(self, label: str, choice: Choice, key: str = "") -> bool:
        """Another method. Raises InputError."""
        before = self.state
        if choice == before.choice:
            return False
        choice.method()
        after = State(before.text, choice, before.selected)
        self.stack.push(EditCommand(self.session, label, before, after, key))
        return True
