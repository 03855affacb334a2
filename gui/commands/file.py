"""Scenes in and out; exports."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtGui import QGuiApplication

from flatland.errors import FlatlandError
from flatland.scene import scene_template
from gui import export
from gui.commands.base import Commands
from gui.models.document import Origin
from gui.models.storage import store_text
from gui.models.track import tracks_to_csv


class FileCommands(Commands):
    """The File menu."""

    def new(self) -> None:
        if self.may_drop():
            self._replace(scene_template(), Origin("untitled"))

    def open(self) -> None:
        path = self.dialogs.open_path("Open scene", "Scenes (*.toml);;All files (*)")
        if path is not None:
            self.open_scene(path)

    def open_scene(self, name_or_path: str | Path) -> bool:
        """Open a built-in scene or a file, or tell every mistake in it."""
        if not self.may_drop():
            return False
        try:
            self.session.document.load(name_or_path)
        except (FlatlandError, OSError, ValueError) as error:
            self.dialogs.tell("This scene cannot be opened", str(error))
            return False
        self._opened()
        path = self.session.document.origin.path
        self.window.settings.opened(path if path is not None else str(name_or_path))
        self.window.settings.save()
        return True

    def _replace(self, text: str, origin: Origin, saved: bool = True) -> None:
        self.session.document.replace(text, origin, saved)
        self._opened()

    def _opened(self) -> None:
        self.editor.stack.clear()
        self.session.selection.set(())
        self.session.selection.pin(None)
        self.session.display.set(layer=None, channel=None, level=None)
        self.window.camera.refit()
        self.window.views.arrange()
        self.window.recovery.forget()

    def gallery(self) -> None:
        name = self.dialogs.gallery()
        if name is not None:
            self.open_scene(name)

    def fill_recent(self) -> None:
        menu = self.window.recent_menu
        menu.clear()
        for name in self.window.settings.recent:
            action = menu.addAction(name)
            action.triggered.connect(lambda _=False, name=name: self.open_scene(self._named(name)))
        if menu.isEmpty():
            menu.addAction("None yet").setEnabled(False)

    @staticmethod
    def _named(name: str) -> str | Path:
        path = Path(name)
        return path if path.is_absolute() else name

    def save(self) -> bool:
        if self.session.document.origin.path is None:
            return self.save_as()
        return self._save(None)

    def save_as(self) -> bool:
        origin = self.session.document.origin
        proposed = origin.path or Path(f"{Path(origin.name).stem.partition(':')[0]}.toml")
        path = self.dialogs.save_path("Save scene", proposed, "Scenes (*.toml)")
        if path is None:
            return False
        return self._save(path if path.suffix else path.with_suffix(".toml"))

    def _save(self, path: Path | None) -> bool:
        try:
            saved = self.session.document.save(path)
        except (FlatlandError, OSError, ValueError) as error:
            self.dialogs.tell("The scene was not saved", str(error))
            return False
        self.editor.stack.setClean()
        self.window.settings.opened(saved)
        self.window.settings.save()
        self.window.recovery.forget()
        self.say(f"saved {saved}")
        return True

    def may_drop(self) -> bool:
        """Whether the scene may go: it is saved, or the user says so."""
        if not self.session.document.dirty:
            return True
        answer = self.dialogs.ask_save(self.session.document.origin.name)
        return answer == "drop" or (answer == "save" and self.save())

    def may_close(self) -> bool:
        """Whether the window may close: nothing unsaved, and no long run that is still wanted."""
        if self.session.busy == "run" and not self.dialogs.sure(
            "A run is still going on. Stop it and close?"
        ):
            return False
        return self.may_drop()

    def quit(self) -> None:
        self.window.close()

    # -- exports --------------------------------------------------------------------------------

    def export_view(self) -> None:
        path = self._target("Export view", "view.pdf", "Pictures (*.pdf *.svg *.png)")
        if path is not None:
            self._export(path, lambda: export.save_views(self.window, path))

    def export_animation(self) -> None:
        path = self._target("Export animation", "run.gif", "Animations (*.gif)")
        if path is not None:
            self._export(path, lambda: export.save_animation(self.window, path))

    def export_data(self) -> None:
        frame = self.session.frame
        if frame is None:
            self.say("there is no light to export yet")
            return
        from flatland.results import result_dataset, save_dataset

        path = self._target("Export data", "run.nc", "netCDF (*.nc)")
        if path is not None:
            method = self.session.choice.method(iterations=frame.iteration).as_dict()
            if frame.converged is not None:
                method = {**method, "iterations": None, "converge": frame.converged.tolerance}
            data = result_dataset(self.session.scene, frame.fields, method)
            self._export(path, lambda: save_dataset(data, path))

    def export_curves(self) -> None:
        path = self._target("Export curves", "curves.csv", "Curves (*.csv *.pdf)")
        if path is None:
            return
        tracks = [self.session.track, *(run.track for run in self.session.runs)]
        if path.suffix.lower() == ".csv":
            text = tracks_to_csv(tracks)
            self._export(path, lambda: store_text(path, text))
        else:
            self._export(path, lambda: export.save_curves(tracks, path))

    def _target(self, title: str, name: str, kinds: str) -> Path | None:
        stem = Path(self.session.document.origin.name).stem.partition(":")[0]
        return self.dialogs.save_path(title, Path(f"{stem}-{name}"), kinds)

    def _export(self, path: Path, write: object) -> None:
        assert callable(write)
        try:
            write()
        except (FlatlandError, OSError, ValueError) as error:
            self.dialogs.tell("This was not exported", str(error))
        else:
            self.say(f"wrote {path}")

    def copy_picture(self) -> None:
        QGuiApplication.clipboard().setImage(export.picture_of(self.window))
        self.say("copied the picture")

    def copy_command(self) -> None:
        QGuiApplication.clipboard().setText(self.session.command_line())
        self.say("copied the command line")

    def copy_scene(self) -> None:
        QGuiApplication.clipboard().setText(self.session.document.text)
        self.say("copied the scene as TOML")
