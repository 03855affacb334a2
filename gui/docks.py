"""The panels round the views."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QWidget

if TYPE_CHECKING:
    from gui.window import Window

_LEFT, _RIGHT = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea


def make_docks(window: Window) -> dict[str, QDockWidget]:
    """A dock for each panel, by its title; those that share a place are tabs."""
    panels: tuple[tuple[str, QWidget, Qt.DockWidgetArea], ...] = (
        ("Method", window.method_panel, _LEFT),
        ("Scene", window.items_panel, _LEFT),
        ("Cell", window.inspector, _RIGHT),
        ("Energy and errors", window.curves, _RIGHT),
        ("Kept runs", window.runs_panel, _RIGHT),
    )
    docks = {title: _dock(window, title, panel, area) for title, panel, area in panels}
    window.tabifyDockWidget(docks["Energy and errors"], docks["Kept runs"])
    window.tabifyDockWidget(docks["Method"], docks["Scene"])
    for name in ("Energy and errors", "Method"):
        docks[name].raise_()
    menu = window.menus["View"].addMenu("Docks")
    for dock in docks.values():
        menu.addAction(dock.toggleViewAction())
    return docks


def _dock(window: Window, title: str, panel: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
    dock = QDockWidget(title, window)
    dock.setObjectName(title)
    dock.setWidget(panel)
    window.addDockWidget(area, dock)
    return dock
