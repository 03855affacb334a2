"""What is kept between sittings: a JSON file that may be damaged without harm."""

from __future__ import annotations

import base64
import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

from flatland.errors import FlatlandError
from gui.models.display import Look, look_from
from gui.models.storage import store_text

MOST_RECENT = 12
THEMES = ("system", "light", "dark")


class Settings:
    """Values by name; whatever cannot be read is as if it had never been stored.

    path: the file, or None to keep nothing.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.values: dict[str, Any] = {}
        if path is not None:
            try:
                stored = json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError, RecursionError):
                stored = None
            if isinstance(stored, dict):
                self.values = stored

    @classmethod
    def in_memory(cls) -> Settings:
        return cls(None)

    @classmethod
    def of_user(cls) -> Settings:
        """In the place where this system keeps settings."""
        import platformdirs

        return cls(Path(platformdirs.user_config_dir("flatland")) / "desktop.json")

    def save(self) -> bool:
        """Write the file if there is one; whether that worked."""
        if self.path is None:
            return True
        text = json.dumps(self.values, indent=1)
        try:
            store_text(self.path, text)
        except (FlatlandError, OSError):
            return False
        return True

    @property
    def theme(self) -> str:
        theme = self.values.get("theme")
        return theme if isinstance(theme, str) and theme in THEMES else "system"

    @theme.setter
    def theme(self, name: str) -> None:
        self.values["theme"] = name

    @property
    def look(self) -> Look:
        return look_from(self.values.get("look"))

    def keep_look(self, look: Look) -> None:
        self.values["look"] = asdict(look)

    @property
    def recent(self) -> list[str]:
        """Scenes opened last, newest first."""
        stored = self.values.get("recent")
        names = stored if isinstance(stored, list) else []
        return [name for name in names if isinstance(name, str) and name][:MOST_RECENT]

    def opened(self, name: str | os.PathLike[str]) -> None:
        """Note a scene as the newest one."""
        text = os.fspath(name)
        others = [each for each in self.recent if each != text]
        self.values["recent"] = [text, *others][:MOST_RECENT]

    def stored_bytes(self, name: str) -> bytes:
        """Stored bytes; none if there are none or they make no sense."""
        stored = self.values.get(name)
        try:
            return base64.b64decode(stored, validate=True) if isinstance(stored, str) else b""
        except ValueError:
            return b""

    def store_bytes(self, name: str, value: bytes) -> None:
        self.values[name] = base64.b64encode(value).decode("ascii")
