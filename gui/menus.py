"""The window's actions and menus, from the table of commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu

from gui.actions import COMMANDS, MENUS, Command
from gui.icons import icon

if TYPE_CHECKING:
    from gui.window import Window

#: Commands with a line above them.
_SEPARATED = {"save", "export_view", "copy_picture", "quit", "cut", "rotate_left", "nudge_left"}
_SEPARATED |= {"clear_lights", "edit_text_dialog", "first", "inject", "faster", "reference"}
_SEPARATED |= {"one_view", "scale_kind", "layer:grid", "slice_axis", "theme"}


def make_actions(window: Window) -> dict[str, QAction]:
    """An action for each command, by its name; `name:argument` where it has one."""
    return {_name(command): _action(window, command) for command in COMMANDS}


def _name(command: Command) -> str:
    return f"{command.name}:{command.argument}" if command.argument else command.name


def _action(window: Window, command: Command) -> QAction:
    action = QAction(command.text, window)
    action.setShortcuts([QKeySequence(keys) for keys in command.keys])
    action.setCheckable(command.checkable)
    keys = QKeySequence(command.keys[0]).toString() if command.keys else ""
    tip = command.tip or command.text
    action.setToolTip(f"{tip} ({keys})" if keys else tip)
    action.setStatusTip(tip)
    if command.name in ("run", "step", "back", "first", "last"):
        action.setIcon(icon(command.name))
        action.setIconVisibleInMenu(False)
    action.triggered.connect(_call(window, command))
    window.addAction(action)
    return action


def _call(window: Window, command: Command) -> Callable[[], None]:
    method = getattr(window.controller, command.name)

    def call() -> None:
        method(command.argument) if command.argument else method()
        window.refresh_actions()

    return call


def make_menus(window: Window) -> dict[str, QMenu]:
    """The menu bar: its menus, by their names."""
    menus = {name: window.menuBar().addMenu(f"&{name}") for name in MENUS}
    for command in COMMANDS:
        name, menu = _name(command), menus[command.menu]
        if name in _SEPARATED:
            menu.addSeparator()
        menu.addAction(window.actions_by_name[name])
        if name == "gallery":
            menu.addMenu(window.recent_menu)
    window.recent_menu.aboutToShow.connect(window.controller.fill_recent)
    return menus


def make_add_menus(window: Window) -> dict[str, QMenu]:
    """What can be added to a scene, by `light` and `occluder`, in the Edit menu."""
    menus = {name: QMenu(f"Add {name}", window) for name in ("light", "occluder")}
    before = window.actions_by_name["clear_lights"]
    for name, menu in menus.items():
        window.menus["Edit"].insertMenu(before, menu)
        menu.aboutToShow.connect(lambda name=name: window.controller.fill_add(name))
    return menus
