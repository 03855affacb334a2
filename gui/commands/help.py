"""Finding commands and keys; what went wrong."""

from __future__ import annotations

from gui.commands.base import Commands


class HelpCommands(Commands):
    """The Help menu, and failures."""

    def palette(self) -> None:
        self.dialogs.palette(self.window.actions_by_name)

    def shortcuts(self) -> None:
        self.dialogs.shortcuts()

    def about(self) -> None:
        from flatland.results import versions

        lines = [f"{name} {number}" for name, number in versions().items()]
        text = "flatland: how light propagates on grids, and what a scheme does to it.\n\n"
        self.dialogs.tell("About flatland", text + "\n".join(lines))

    def tell_failure(self, title: str, text: str, details: str) -> None:
        """A failed job: what the user can do something about in the status bar, faults in a
        window."""
        if details:
            self.dialogs.fault(title, text, details)
        else:
            self.say(f"{title}: {text}")
