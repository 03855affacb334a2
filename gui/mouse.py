"""The mouse on a canvas: strokes of the tools, handles, and snapping."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QMouseEvent

from flatland.errors import InputError
from gui.models import edits
from gui.models.picking import item_near, items_along, items_within, tables_named
from gui.models.session import Session
from gui.models.shapes import (
    Handle,
    Place,
    Table,
    drag_handle,
    handles_of,
    transformed,
)
from gui.models.tools import Point, Tool, constrained, snapped, stroke_tables
from gui.undo import Editor

if TYPE_CHECKING:
    from gui.widgets.canvas import Canvas

#: How near the mouse must be to an item or a handle [logical pixels].
REACH = 7.0
_CURSORS = {
    Tool.INJECT: Qt.CursorShape.CrossCursor,
    Tool.OCCLUDE: Qt.CursorShape.CrossCursor,
    Tool.ERASE: Qt.CursorShape.ForbiddenCursor,
    Tool.PICK_UP: Qt.CursorShape.PointingHandCursor,
    Tool.SELECT: Qt.CursorShape.ArrowCursor,
    Tool.PAN: Qt.CursorShape.OpenHandCursor,
}
_NAMES = {Tool.INJECT: "light", Tool.OCCLUDE: "occluder"}


class Mouse:
    """One for all canvases: a stroke begins and ends in one of them.

    Ctrl snaps to corners and middles of cells, Shift keeps lines to multiples of 45 degrees, Esc
    drops the stroke in hand. Every stroke is one step of undo.
    """

    def __init__(self, session: Session, editor: Editor) -> None:
        self.session, self.editor = session, editor
        self.rectangle: tuple[Point, Point] | None = None
        self._path: list[Point] = []
        self._erased: list[Place] = []
        self._handle: tuple[Place, Handle] | None = None
        self._moving = False
        self._doing, self._name = "", "light"

    @property
    def drawing(self) -> bool:
        return bool(self._doing)

    def pans(self, event: QMouseEvent) -> bool:
        return self.session.tool is Tool.PAN and event.button() == Qt.MouseButton.LeftButton

    def set_cursor(self, canvas: Canvas) -> None:
        canvas.setCursor(_CURSORS[self.session.tool])

    # -- events ---------------------------------------------------------------------------------

    def press(self, canvas: Canvas, event: QMouseEvent) -> None:
        if self._doing:
            return
        tool, at = self.session.tool, self._place(canvas, event)
        self._path = [at]
        if event.button() == Qt.MouseButton.RightButton or tool is Tool.ERASE:
            self._doing, self._erased = "erase", []
            self._erase(canvas, event)
        elif event.button() != Qt.MouseButton.LeftButton:
            self._path = []
        elif tool in _NAMES:
            self._doing, self._name = "draw", _NAMES[tool]
            canvas.update()
        elif tool is Tool.PICK_UP:
            self._pick_up(canvas, event)
        elif tool is Tool.SELECT:
            self._press_select(canvas, event)

    def move(self, canvas: Canvas, event: QMouseEvent) -> None:
        if not self._doing:
            return
        at = self._place(canvas, event)
        if self._doing == "erase":
            self._erase(canvas, event)
        self._path.append(at)
        if self._doing == "rectangle":
            self.rectangle = self._path[0], at
        canvas.update()

    def release(self, canvas: Canvas, event: QMouseEvent) -> None:
        if not self._doing:
            return
        self._path.append(self._place(canvas, event))
        doing, self._doing = self._doing, ""
        try:
            getattr(self, f"_end_{doing}")(canvas, event)
        except InputError as error:
            self.session.noticed.emit(str(error))
        self._clear(canvas)

    def drop(self) -> None:
        """Forget the stroke in hand."""
        self._doing = ""
        self._path, self._erased, self._handle, self.rectangle = [], [], None, None

    def _clear(self, canvas: Canvas) -> None:
        self.drop()
        canvas.update()

    # -- what is in hand ------------------------------------------------------------------------

    def ghosts(self) -> list[tuple[str, Table]]:
        """Items as they would be if the stroke ended now."""
        if not self._path:
            return []
        if self._doing == "draw":
            return [(self._name, table) for table in self._drawn(self._name)]
        if self._doing == "handle" and self._handle is not None:
            place, handle = self._handle
            name, table = place[0], self._table(place)
            return [(name, {**table, **self._dragged(name, table, handle)})]
        if self._doing == "items":
            shift = self._shift()
            return [
                (name, {**table, **self._moved(name, table, shift)})
                for name, index in self.session.selection.items
                for table in tables_named(self.session, name)[index : index + 1]
            ]
        return []

    def _drawn(self, name: str) -> list[Table]:
        return stroke_tables(
            name, self.session.brush, self._path, self.session.scene.grid, self.session.plane
        )

    def _dragged(self, name: str, table: Table, handle: Handle) -> Table:
        grid, plane = self.session.scene.grid, self.session.plane
        return drag_handle(name, table, handle, self._path[-1], grid, plane)

    def _moved(self, name: str, table: Table, shift: Any) -> Table:
        grid = self.session.scene.grid
        zero = np.zeros(grid.dimension)
        return transformed(name, table, np.eye(grid.dimension), zero, shift, grid)

    def _shift(self) -> Any:
        plane, grid = self.session.plane, self.session.scene.grid
        right, up = np.subtract(self._path[-1], self._path[0])
        return np.array(plane.lift((right, up), 0.0, grid.dimension))

    # -- ends of strokes ------------------------------------------------------------------------

    def _end_draw(self, canvas: Canvas, event: QMouseEvent) -> None:
        name = self._name
        if tables := self._drawn(name):
            text, places = edits.add(self.session.document.text, name, tables)
            count = f"{len(tables)} {name}s" if len(tables) > 1 else name
            self.editor.edit_text(f"Draw {count}", text, tuple(places[-1:]))

    def _end_erase(self, canvas: Canvas, event: QMouseEvent) -> None:
        text = edits.remove(self.session.document.text, self._erased)
        self.editor.edit_text("Erase", text, ())

    def _end_rectangle(self, canvas: Canvas, event: QMouseEvent) -> None:
        ends = np.array([self._path[0], self._path[-1]])
        low, high = ends.min(axis=0), ends.max(axis=0)
        reach = 3 / canvas.frame.zoom * self.session.scene.grid.spacing
        if np.all(high - low < reach):
            at = event.position()
            cell = canvas.frame.cell_at(at.x(), at.y())
            self.session.selection.set(())
            pinned = self.session.selection.pinned
            self.session.selection.pin(None if cell == pinned else cell)
            return
        found = items_within(self.session, low, high)
        more = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        self.session.selection.set([*self.session.selection.items, *found] if more else found)

    def _end_items(self, canvas: Canvas, event: QMouseEvent) -> None:
        shift = self._shift()
        if np.abs(shift).max() == 0:
            return
        text = edits.move(
            self.session.document.text,
            self.session.selection.items,
            shift,
            self.session.scene.grid,
        )
        self.editor.edit_text("Move", text)

    def _end_handle(self, canvas: Canvas, event: QMouseEvent) -> None:
        if self._handle is None or len(set(self._path)) < 2:
            return
        place, handle = self._handle
        changes = self._dragged(place[0], self._table(place), handle)
        text = edits.change(self.session.document.text, place, changes)
        self.editor.edit_text(f"Drag {handle.key}", text)

    # -- beginnings -----------------------------------------------------------------------------

    def _press_select(self, canvas: Canvas, event: QMouseEvent) -> None:
        grabbed = self._handle_at(canvas, event)
        if grabbed is not None:
            self._handle, self._doing = grabbed, "handle"
            return
        place = self._item_at(canvas, event)
        if place is None:
            self._doing = "rectangle"
        elif event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self.session.selection.toggle(place)
        else:
            if place not in self.session.selection.items:
                self.session.selection.set([place])
            self._doing = "items"

    def _pick_up(self, canvas: Canvas, event: QMouseEvent) -> None:
        place = self._item_at(canvas, event)
        if place is None:
            return
        table = self._table(place)
        self.session.brush.take(place[0], table)
        self.session.selection.set([place])
        self.session.noticed.emit(f"drawing {table['kind']} {place[0]}s like this one now")
        self.session.tool_changed.emit()

    def _erase(self, canvas: Canvas, event: QMouseEvent) -> None:
        """Mark what lies between the last place and this one."""
        place = self._place(canvas, event)
        found = items_along(self.session, self._path[-1], place, self._reach(canvas))
        self._erased = list(dict.fromkeys([*self._erased, *found]))
        self.session.selection.set(self._erased)

    # -- finding --------------------------------------------------------------------------------

    def _place(self, canvas: Canvas, event: QMouseEvent) -> Point:
        at = event.position()
        place = canvas.frame.world_at(at.x(), at.y())
        modifiers = event.modifiers()
        if modifiers & Qt.KeyboardModifier.ControlModifier:
            place = snapped(place, self.session.scene.grid, self.session.plane)
        if modifiers & Qt.KeyboardModifier.ShiftModifier and self._doing in ("draw", "handle"):
            place = constrained(self._fixed(), place)
        return place

    def _fixed(self) -> Point:
        """The end of a line that stays where it is."""
        if self._doing == "handle" and self._handle is not None:
            place, handle = self._handle
            table = self._table(place)
            other = {"start": "end", "end": "start"}.get(handle.key)
            if other in table:
                x, y = self.session.plane.project(np.array(table[other], float))
                return float(x), float(y)
        return self._path[0]

    def _table(self, place: Place) -> Table:
        name, index = place
        return tables_named(self.session, name)[index]

    @staticmethod
    def _reach(canvas: Canvas) -> float:
        """REACH in the plane [m]."""
        frame = canvas.frame
        return REACH / frame.zoom * frame.ratio * frame.grid.spacing

    def _item_at(self, canvas: Canvas, event: QMouseEvent) -> Place | None:
        at = event.position()
        point = canvas.frame.world_at(at.x(), at.y())
        return item_near(self.session, point, self._reach(canvas))

    def _handle_at(self, canvas: Canvas, event: QMouseEvent) -> tuple[Place, Handle] | None:
        at, frame = event.position(), canvas.frame
        for place in self.session.selection.items:
            tables = tables_named(self.session, place[0])
            if place[1] >= len(tables):
                continue
            for handle in handles_of(place[0], tables[place[1]], frame.grid, frame.plane):
                x, y = frame.pixels(np.array(handle.at))
                if max(abs(x - at.x()), abs(y - at.y())) <= REACH:
                    return place, handle
        return None
