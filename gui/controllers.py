"""All commands of the window, and which of them can be used now."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtGui import QAction

from gui.commands.edit import EditCommands
from gui.commands.file import FileCommands
from gui.commands.help import HelpCommands
from gui.commands.run import RunCommands
from gui.commands.view import ViewCommands
from gui.icons import icon


class Controller(FileCommands, EditCommands, RunCommands, ViewCommands, HelpCommands):
    """One method per command of gui.actions."""

    def refresh_actions(self, actions: Mapping[str, QAction]) -> None:
        """Ticks, texts and what is grey, from the models."""
        session, stack = self.session, self.editor.stack
        look = session.display.look
        for name, action in actions.items():
            kind, _, argument = name.partition(":")
            if kind == "tool":
                action.setChecked(session.tool.name == argument)
            elif kind == "view":
                action.setChecked(argument in look.views)
            elif kind == "layer":
                action.setChecked(argument in look.layers)
        actions["overlay"].setChecked(look.overlay)
        running = session.busy in ("run", "solve", "step")
        actions["run"].setChecked(running)
        actions["run"].setText("Pause" if running else "Run")
        actions["run"].setIcon(icon("pause" if running else "run"))
        for name, verb, text, able in (
            ("undo", "Undo", stack.undoText(), stack.canUndo()),
            ("redo", "Redo", stack.redoText(), stack.canRedo()),
        ):
            actions[name].setText(f"{verb} {text[:1].lower()}{text[1:]}" if text else verb)
            actions[name].setEnabled(able)
        selected = bool(session.selection.items)
        for name in ("cut", "copy", "delete", "rotate_left", "rotate_right", "mirror_across"):
            actions[name].setEnabled(selected)
        for name in ("mirror_down", "nudge_left", "nudge_right", "nudge_up", "nudge_down"):
            actions[name].setEnabled(selected)
        actions["clear_lights"].setEnabled(bool(session.scene.lights))
        actions["clear_occluders"].setEnabled(bool(session.scene.occluders))
        for name in ("slice_axis", "slice_up", "slice_down"):
            actions[name].setEnabled(session.scene.grid.dimension == 3)
        for name in ("step", "run", "run_count", "step_many", "back", "back_many"):
            actions[name].setEnabled(session.choice.steps)

    def closed(self) -> None:
        """The window is going."""
        self.window.recovery.close()
