"""The scene being edited: a text, its value, and where it is stored."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from flatland.scene import Scene, builtin_text, load_scene, parse_scene, scene_template
from flatland.scene.catalogue import BUILTIN_DIRECTORY, is_builtin
from gui.models.events import Event
from gui.models.storage import store_text


@dataclass(frozen=True)
class Origin:
    """Where a scene came from. path: its file, or None. name: what to call it.

    directory: where names of data files in it start.
    """

    name: str
    path: Path | None = None
    directory: Path = Path()


class SceneDocument:
    """A valid scene as TOML text; what is not valid never gets in.

    `changed` is emitted after every change of the text, `renamed` after one of origin or of
    whether it is saved.
    """

    def __init__(self, text: str | None = None, origin: Origin | None = None) -> None:
        self.changed, self.renamed = Event(), Event()
        self.origin = origin or Origin("untitled")
        self.text = scene_template() if text is None else text
        self.scene: Scene = self.parse(self.text)
        self._saved = self.text

    @classmethod
    def open(cls, name_or_path: str | os.PathLike[str]) -> SceneDocument:
        """A built-in scene by name, or a file. Raises SceneError with every mistake."""
        document = cls()
        document.load(name_or_path)
        return document

    def load(self, name_or_path: str | os.PathLike[str]) -> None:
        """Replace all by another scene; untouched if that cannot be read. Raises SceneError."""
        load_scene(name_or_path)  # tells every mistake by file and line
        name = os.fspath(name_or_path)
        if isinstance(name_or_path, str) and is_builtin(name):
            self.replace(builtin_text(name), Origin(name, directory=BUILTIN_DIRECTORY))
        else:
            path = Path(name).resolve()
            text = path.read_text(encoding="utf-8-sig")
            self.replace(text, Origin(path.name, path, path.parent))

    def replace(self, text: str, origin: Origin, saved: bool = True) -> None:
        """Another scene altogether. saved: whether the text is what its file holds."""
        scene = parse_scene(text, origin.name, origin.directory)
        self.origin, self.text, self.scene = origin, text, scene
        self._saved = text if saved else ""
        self.renamed.emit()
        self.changed.emit()

    def parse(self, text: str) -> Scene:
        """What a text would mean here. Raises SceneError."""
        return parse_scene(text, self.origin.name, self.origin.directory)

    def set_text(self, text: str) -> None:
        """A new text of the same scene. Raises SceneError and then changes nothing."""
        if text == self.text:
            return
        scene = self.parse(text)
        self.text, self.scene = text, scene
        self.changed.emit()
        self.renamed.emit()

    @property
    def dirty(self) -> bool:
        """Whether there is something that no file holds."""
        return self.text != self._saved

    @property
    def title(self) -> str:
        return self.scene.title or self.origin.name

    def save(self, path: str | os.PathLike[str] | None = None) -> Path:
        """Write the text, whole or not at all. Raises ResultFileError, SceneError.

        path: where; the file it came from without it. A scene with data files, saved into another
        directory, must find them there.
        """
        target = Path(path) if path is not None else self.origin.path
        if target is None:
            raise ValueError("a scene that came from no file needs a path")
        target = target.resolve()
        scene = parse_scene(self.text, target.name, target.parent)
        store_text(target, self.text)
        self.origin, self.scene = Origin(target.name, target, target.parent), scene
        self._saved = self.text
        self.renamed.emit()
        return target

    @property
    def command_name(self) -> str | None:
        """What the command line calls this scene; None if only the window has it."""
        if self.dirty:
            return None
        return self.origin.name if self.origin.path is None else str(self.origin.path)
