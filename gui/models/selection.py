"""What is selected: items of the scene, and cells that are looked at."""

from __future__ import annotations

from collections.abc import Iterable

from gui.models.events import Event
from gui.models.shapes import Place


class Selection:
    """Items by place, the pinned cell and the cell under the mouse."""

    def __init__(self) -> None:
        self.items: tuple[Place, ...] = ()
        self.pinned: tuple[int, ...] | None = None
        self.hovered: tuple[int, ...] | None = None
        self.changed, self.pin_changed, self.hover_changed = Event(), Event(), Event()

    def set(self, items: Iterable[Place]) -> None:
        items = tuple(dict.fromkeys(items))
        if items != self.items:
            self.items = items
            self.changed.emit()

    def toggle(self, place: Place) -> None:
        others = [item for item in self.items if item != place]
        self.set(others if place in self.items else [*others, place])

    def pin(self, cell: tuple[int, ...] | None) -> None:
        if cell != self.pinned:
            self.pinned = cell
            self.pin_changed.emit()

    def hover(self, cell: tuple[int, ...] | None) -> None:
        if cell != self.hovered:
            self.hovered = cell
            self.hover_changed.emit()
