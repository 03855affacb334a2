"""Edits of the scene."""

from __future__ import annotations

import json

import numpy as np
from PySide6.QtCore import QMimeData
from PySide6.QtGui import QGuiApplication

from flatland.errors import FlatlandError
from flatland.scene.writing import tables_to_toml
from gui.commands.base import Commands
from gui.models import edits
from gui.models.fields import REGISTRIES, specs_of_kind
from gui.models.toml_text import tables_of

#: Items on the clipboard, as JSON.
MIME = "application/x-flatland-items"


class EditCommands(Commands):
    """The Edit menu."""

    def undo(self) -> None:
        self.editor.stack.undo()

    def redo(self) -> None:
        self.editor.stack.redo()

    def copy(self) -> None:
        tables = edits.copied(self.session.document.text, self.session.selection.items)
        if not tables:
            return
        data = QMimeData()
        data.setData(MIME, json.dumps(tables).encode())
        data.setText(tables_to_toml(tables))
        QGuiApplication.clipboard().setMimeData(data)

    def cut(self) -> None:
        self.copy()
        self._remove("Cut")

    def paste(self) -> None:
        data = QGuiApplication.clipboard().mimeData()
        if data is None or not data.hasFormat(MIME):
            self.say("nothing to paste: copy lights or occluders first")
            return
        tables = json.loads(bytes(data.data(MIME).data()).decode())
        grid = self.session.scene.grid
        try:
            text, places = edits.paste(self.session.document.text, tables)
            aside = np.array(
                self.session.plane.lift((grid.spacing, -grid.spacing), 0.0, grid.dimension)
            )
            moved = edits.move(text, places, aside, grid)
        except (FlatlandError, ValueError, IndexError, KeyError, TypeError) as error:
            self.say(f"this does not fit here: {error}")
            return
        try:
            self.editor.edit_text("Paste", moved, tuple(places))
        except FlatlandError:
            self.edit_text("Paste", text, tuple(places))

    def delete(self) -> None:
        self._remove("Delete")

    def _remove(self, label: str) -> None:
        text = edits.remove(self.session.document.text, self.session.selection.items)
        self.edit_text(label, text, ())

    def select_all(self) -> None:
        tables = tables_of(self.session.document.text)
        self.session.selection.set(
            (name, i) for name in ("light", "occluder") for i in range(len(tables.get(name, [])))
        )

    def rotate_left(self) -> None:
        self._turn("Rotate left", 1)

    def rotate_right(self) -> None:
        self._turn("Rotate right", -1)

    def _turn(self, label: str, quarters: int) -> None:
        plane, dimension = self.session.plane, self.session.scene.grid.dimension
        self._transform(label, edits.turn_matrix(quarters, plane, dimension))

    def mirror_across(self) -> None:
        self._mirror("Mirror left to right", 0)

    def mirror_down(self) -> None:
        self._mirror("Mirror top to bottom", 1)

    def _mirror(self, label: str, axis: int) -> None:
        plane, dimension = self.session.plane, self.session.scene.grid.dimension
        self._transform(label, edits.mirror_matrix(axis, plane, dimension))

    def _transform(self, label: str, matrix: np.ndarray) -> None:
        items, text = self.session.selection.items, self.session.document.text
        if not items:
            self.say("select something first (tool 5)")
            return
        grid = self.session.scene.grid
        about = edits.middle_of(text, items, grid, self.session.plane)
        self.edit_text(label, edits.transform(text, items, matrix, about, grid))

    def nudge_left(self) -> None:
        self._nudge(-1, 0)

    def nudge_right(self) -> None:
        self._nudge(1, 0)

    def nudge_up(self) -> None:
        self._nudge(0, 1)

    def nudge_down(self) -> None:
        self._nudge(0, -1)

    def _nudge(self, right: int, up: int) -> None:
        grid = self.session.scene.grid
        shift = self.session.plane.lift(
            (right * grid.spacing, up * grid.spacing), 0.0, grid.dimension
        )
        items = self.session.selection.items
        self.edit_text("Move", edits.move(self.session.document.text, items, shift, grid))

    def clear_lights(self) -> None:
        self.edit_text("Clear lights", edits.clear(self.session.document.text, "light"), ())

    def clear_occluders(self) -> None:
        text = edits.clear(self.session.document.text, "occluder")
        self.edit_text("Clear occluders", text, ())

    def edit_text_dialog(self) -> None:
        document = self.session.document
        text = self.dialogs.edit_scene(document.text, document.parse)
        if text is not None:
            self.edit_text("Edit text", text, ())

    def fill_add(self, name: str) -> None:
        """The menu of kinds that can be added to this grid."""
        menu = self.window.add_menus[name]
        menu.clear()
        dimension = self.session.scene.grid.dimension
        for kind, model in REGISTRIES[name].items():
            if dimension in model.dimensions:
                description = model.model_fields["kind"].description or ""
                action = menu.addAction(kind.capitalize())
                action.setToolTip(description)
                action.triggered.connect(lambda _=False, kind=kind: self.add_item(name, kind))
        menu.setToolTipsVisible(True)

    def add_item(self, name: str, kind: str) -> None:
        """A new item in the middle of the view, selected, ready to be changed."""
        grid, plane = self.session.scene.grid, self.session.plane
        table = edits.starting_table(name, kind, grid, plane)
        for spec in specs_of_kind(name, kind):
            if spec.kind == "file" and spec.required:
                path = self.dialogs.open_path(f"File of the {kind}", "All files (*)")
                if path is None:
                    return
                table[spec.key] = str(path)
        text, places = edits.add(self.session.document.text, name, [table])
        if self.edit_text(f"Add {kind} {name}", text, tuple(places)):
            self.window.docks["Scene"].show()
