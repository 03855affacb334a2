"""The unsaved scene, kept aside so that a crash does not lose it."""

from __future__ import annotations

import ctypes
import json
import os
import time
from dataclasses import dataclass
from pathlib import Path

from flatland.errors import FlatlandError
from gui.models.document import Origin, SceneDocument
from gui.models.storage import store_text


@dataclass(frozen=True)
class Lost:
    """A scene that a sitting left behind. when: seconds since 1970."""

    text: str
    origin: Origin
    when: float
    file: Path


class Recovery:
    """One file per process in a folder; a file whose process is gone tells of a crash.

    directory: where, or None to keep nothing.
    """

    def __init__(self, document: SceneDocument, directory: Path | None) -> None:
        self.document, self.directory = document, directory
        self._kept = ""

    @property
    def file(self) -> Path | None:
        return None if self.directory is None else self.directory / f"unsaved-{os.getpid()}.json"

    def keep(self) -> bool:
        """Store the scene if it has unsaved changes that are not stored yet; whether it was."""
        if self.file is None or not self.document.dirty or self.document.text == self._kept:
            return False
        origin = self.document.origin
        record = {
            "process": os.getpid(),
            "when": time.time(),
            "name": origin.name,
            "path": str(origin.path) if origin.path else None,
            "directory": str(origin.directory),
            "text": self.document.text,
        }
        content = json.dumps(record)
        try:
            store_text(self.file, content)
        except (FlatlandError, OSError):
            return False
        self._kept = self.document.text
        return True

    def forget(self) -> None:
        """What was kept is saved, or no longer wanted."""
        self._kept = ""
        if self.file is not None:
            self.file.unlink(missing_ok=True)

    def lost(self) -> list[Lost]:
        """Scenes of sittings that did not end well, newest first; damaged files are passed over."""
        if self.directory is None or not self.directory.is_dir():
            return []
        found = [_read(path) for path in self.directory.glob("unsaved-*.json")]
        good = [each for each in found if each is not None]
        return sorted(good, key=lambda each: -each.when)


def _read(path: Path) -> Lost | None:
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        process = int(record["process"])
        if process == os.getpid() or _alive(process):
            return None
        place = Path(record["path"]) if record["path"] else None
        origin = Origin(str(record["name"]), place, Path(record["directory"]))
        return Lost(str(record["text"]), origin, float(record["when"]), path)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _alive(process: int) -> bool:
    if os.name == "nt":  # there, signal 0 would end the process
        kernel = getattr(ctypes, "windll").kernel32  # noqa: B009 - unknown to type checkers here
        handle = kernel.OpenProcess(0x1000, False, process)  # only to ask about it
        if handle:
            kernel.CloseHandle(handle)
        return bool(handle)
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
