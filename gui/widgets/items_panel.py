"""The scene: its grid, its lights and occluders, and the keys of the selected one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from PySide6.QtCore import QItemSelectionModel, Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QPushButton,
    QScrollArea,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from flatland.errors import InputError
from flatland.scene import GridTable
from gui.models import edits
from gui.models.fields import FieldSpec, specs_of, specs_of_kind
from gui.models.session import Session
from gui.models.shapes import Place
from gui.models.toml_text import tables_of, update_table
from gui.undo import Editor
from gui.widgets.blocking import quiet
from gui.widgets.values import ValueControl, control_for, toml_value

#: Items shown in the list; more are counted. Scenes of thousands are edited as text.
MOST_LISTED = 2000
TITLE = FieldSpec("title", "text", "one line that says what the scene shows", False, "")


class ItemsPanel(QWidget):
    """A list of items, and an editor made from what the selected one declares."""

    def __init__(self, session: Session, editor: Editor, menus: Mapping[str, QMenu]) -> None:
        super().__init__()
        self.session, self.editor = session, editor
        self.list = QListWidget()
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.list.setAccessibleName("Lights and occluders")
        self.list.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.itemSelectionChanged.connect(self._selected)
        buttons = QHBoxLayout()
        for name, menu in menus.items():
            button = QPushButton(f"Add {name}")
            button.setMenu(menu)
            buttons.addWidget(button)
        self.fields = QWidget()
        self.form = QFormLayout(self.fields)
        self.form.setContentsMargins(6, 4, 6, 4)
        self.form.setVerticalSpacing(4)
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setWidget(self.fields)
        upper = QWidget()
        column = QVBoxLayout(upper)
        column.setContentsMargins(6, 4, 6, 0)
        column.addWidget(self.list)
        column.addLayout(buttons)
        split = QSplitter(Qt.Orientation.Vertical)
        split.addWidget(upper)
        split.addWidget(scroll)
        split.setSizes([220, 320])
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(split)
        self.controls: dict[str, ValueControl] = {}
        self._built: tuple[str, str] | None = None
        session.document.changed.connect(self.refresh)
        session.selection.changed.connect(self.refresh_selection)
        self.refresh()

    # -- following the models -------------------------------------------------------------------

    def refresh(self) -> None:
        tables = tables_of(self.session.document.text)
        entries = [
            (name, i, table)
            for name in ("light", "occluder")
            for i, table in enumerate(tables.get(name, []))
        ][:MOST_LISTED]
        with quiet(self.list):
            while self.list.count() > len(entries):
                self.list.takeItem(self.list.count() - 1)
            while self.list.count() < len(entries):
                self.list.addItem(QListWidgetItem())
            for row, (name, i, table) in enumerate(entries):
                item = self.list.item(row)
                item.setText(f"{name} {i + 1}: {table.get('kind')}{_told(table)}")
                item.setData(Qt.ItemDataRole.UserRole, (name, i))
        self.refresh_selection()

    def refresh_selection(self) -> None:
        chosen = set(self.session.selection.items)
        with quiet(self.list, self.list.selectionModel()):
            model = self.list.selectionModel()
            for row in range(self.list.count()):
                place = tuple(self.list.item(row).data(Qt.ItemDataRole.UserRole))
                flag = QItemSelectionModel.SelectionFlag
                model.select(
                    self.list.model().index(row, 0),
                    flag.Select if place in chosen else flag.Deselect,
                )
        self.list.viewport().update()
        self._show_fields()

    def _show_fields(self) -> None:
        place = self._place
        tables = tables_of(self.session.document.text)
        if place is None:
            self._build("grid", "", [TITLE, *specs_of(GridTable)])
            values: dict[str, Any] = {"title": tables.get("title"), **tables["grid"]}
        else:
            values = tables[place[0]][place[1]]
            kind = str(values.get("kind"))
            self._build(place[0], kind, list(specs_of_kind(place[0], kind)))
        for key, control in self.controls.items():
            control.show_value(values.get(key))

    def _build(self, name: str, kind: str, specs: list[FieldSpec]) -> None:
        if self._built == (name, kind):
            return
        self._built = name, kind
        while self.form.rowCount():
            self.form.removeRow(0)
        self.controls = {}
        heading = QLabel(f"<b>{kind} {name}</b>" if kind else "<b>Grid</b>")
        self.form.addRow(heading)
        for spec in specs:
            control = control_for(spec)
            control.edited.connect(lambda value, key=spec.key: self._edited(key, value))
            label = QLabel(spec.key.capitalize())
            label.setToolTip(spec.meaning)
            self.form.addRow(label, control)
            self.controls[spec.key] = control

    @property
    def _place(self) -> Place | None:
        """The one selected item; None for none or several."""
        items = self.session.selection.items
        if len(items) != 1:
            return None
        name, index = items[0]
        return items[0] if index < len(self._tables(name)) else None

    def _tables(self, name: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = tables_of(self.session.document.text).get(name, [])
        return found

    # -- edits ----------------------------------------------------------------------------------

    def _selected(self) -> None:
        rows = self.list.selectedItems()
        places = [tuple(row.data(Qt.ItemDataRole.UserRole)) for row in rows]
        self.session.selection.set([(str(name), int(i)) for name, i in places])

    def _edited(self, key: str, value: Any) -> None:
        text, place = self.session.document.text, self._place
        if place is None:
            path: tuple[str | int, ...] = () if key == "title" else ("grid",)
            new, what = update_table(text, path, {key: value}), f"grid {key}"
        else:
            new, what = edits.change(text, place, {key: value}), f"{place} {key}"
        try:
            self.editor.edit_text(f"Change {key}", new, key=f"value {what}")
        except InputError as error:
            self.session.noticed.emit(str(error))
            self._show_fields()


def _told(table: Mapping[str, Any]) -> str:
    """The strength of a light or the albedo of an occluder, for the list."""
    for key, unit in (("flux", " W"), ("radiance", ""), ("irradiance", ""), ("albedo", "")):
        if key in table:
            return f", {key} {toml_value(table[key])}{unit}"
    return ""
