"""The main window: puts models, worker, views and docks together."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QByteArray, Qt
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QKeySequence,
    QShowEvent,
)
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QMainWindow,
    QMenu,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from gui.actions import COMMANDS, MENUS, Command
from gui.autosave import AutoSave
from gui.controllers import Controller
from gui.icons import icon
from gui.keys import Keys
from gui.models.camera import Camera
from gui.models.engine import Engine
from gui.models.exact import ExactSolver
from gui.models.session import Session
from gui.models.settings import Settings
from gui.mouse import Mouse
from gui.render.stage import Stage
from gui.theme import apply_theme
from gui.undo import Editor
from gui.widgets.curves import CurvesPanel
from gui.widgets.inspector import Inspector
from gui.widgets.items_panel import ItemsPanel
from gui.widgets.method_panel import MethodPanel
from gui.widgets.runs_panel import RunsPanel
from gui.widgets.scale_bar import ScaleBar
from gui.widgets.slice_bar import SliceBar
from gui.widgets.status import Status
from gui.widgets.timeline import TimeLine
from gui.widgets.view_area import ViewArea
from gui.widgets.view_painter import ViewPainter
from gui.worker import Worker

#: Grows when docks are added, so that an old layout is not restored.
LAYOUT_VERSION = 3


class Window(QMainWindow):
    """Everything on screen. What commands do is in gui.controllers."""

    def __init__(
        self,
        session: Session | None = None,
        settings: Settings | None = None,
        state_folder: Path | None = None,
    ) -> None:
        super().__init__()
        self._shut = False
        self.settings = settings or Settings.in_memory()
        self.session = session or Session(look=self.settings.look)
        self.camera, self.editor = Camera(), Editor(self.session, self)
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        self.stage = Stage(self.session, apply_theme(application, self.settings.theme))
        self.painter = ViewPainter(self.session, self.stage)
        self.mouse = Mouse(self.session, self.editor)
        self.views = ViewArea(self.session, self.camera, self.painter, self.mouse)
        self.controller = Controller(self)
        self.actions_by_name: dict[str, QAction] = {}
        self.recent_menu = QMenu("Open recent", self)
        self.recovery = AutoSave(self, state_folder)
        self.keys = Keys(self, self.views)
        self._make_actions()
        self._make_menus()
        self._make_workers()
        self._make_controls()
        self._make_docks()
        self._bind()
        self.setAcceptDrops(True)
        self._first_state = self.saveState(LAYOUT_VERSION)
        self._restore_layout()
        self.refresh_actions()
        self.refresh_title()

    # -- construction ---------------------------------------------------------------------------

    def _make_actions(self) -> None:
        for command in COMMANDS:
            action = QAction(command.text, self)
            action.setShortcuts([QKeySequence(keys) for keys in command.keys])
            action.setCheckable(command.checkable)
            keys = QKeySequence(command.keys[0]).toString() if command.keys else ""
            tip = command.tip or command.text
            action.setToolTip(f"{tip} ({keys})" if keys else tip)
            action.setStatusTip(tip)
            if command.name in ("run", "step", "back", "first", "last"):
                action.setIcon(icon(command.name))
                action.setIconVisibleInMenu(False)
            action.triggered.connect(self._call(command))
            self.addAction(action)
            name = f"{command.name}:{command.argument}" if command.argument else command.name
            self.actions_by_name[name] = action

    def _call(self, command: Command) -> Callable[[], None]:
        method = getattr(self.controller, command.name)

        def call() -> None:
            method(command.argument) if command.argument else method()
            self.refresh_actions()

        return call

    def _make_menus(self) -> None:
        self.menus = {name: self.menuBar().addMenu(f"&{name}") for name in MENUS}
        separated = {"save", "export_view", "copy_picture", "quit", "cut", "rotate_left"}
        separated |= {"nudge_left", "clear_lights", "edit_text_dialog", "first", "inject", "faster"}
        separated |= {"reference", "one_view", "scale_kind", "layer:grid", "slice_axis", "theme"}
        for command in COMMANDS:
            name = f"{command.name}:{command.argument}" if command.argument else command.name
            menu = self.menus[command.menu]
            if name in separated:
                menu.addSeparator()
            menu.addAction(self.actions_by_name[name])
            if name == "gallery":
                menu.addMenu(self.recent_menu)
        self.add_menus = {name: QMenu(f"Add {name}", self) for name in ("light", "occluder")}
        before = self.actions_by_name["clear_lights"]
        for menu in self.add_menus.values():
            self.menus["Edit"].insertMenu(before, menu)
        self.recent_menu.aboutToShow.connect(self.controller.fill_recent)
        for name, menu in self.add_menus.items():
            menu.aboutToShow.connect(lambda name=name: self.controller.fill_add(name))

    def _make_workers(self) -> None:
        self.engine = Engine()
        self.worker = Worker(self.engine, self)
        self.reference_worker = Worker(ExactSolver(), self)
        session, worker, reference = self.session, self.worker, self.reference_worker
        worker.arrived.connect(session.take_frame)
        worker.busy_with.connect(session.take_busy)
        worker.failed.connect(session.take_failure)
        worker.noticed.connect(session.noticed.emit)
        worker.told_progress.connect(session.progressed.emit)
        reference.finished_job.connect(session.reference.take)
        reference.failed.connect(session.take_failure)
        session.runner, session.reference.runner = worker, reference

    def _make_controls(self) -> None:
        self.timeline = TimeLine(self.session, self.actions_by_name)
        self.scale_bar = ScaleBar(self.stage)
        self.slice_bar = SliceBar(self.session)
        self.status = Status(self.session)
        self.setStatusBar(self.status)
        tools = QToolBar("Tools")
        tools.setObjectName("tools")
        tools.setOrientation(Qt.Orientation.Vertical)
        for name, action in self.actions_by_name.items():
            if name.startswith("tool:"):
                tools.addAction(action)
        self.addToolBar(Qt.ToolBarArea.TopToolBarArea, tools)
        tools.addSeparator()
        for name, action in self.actions_by_name.items():
            if name.startswith("view:") or name in ("overlay", "heat", "reference", "keep"):
                tools.addAction(action)
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(2, 2, 2, 0)
        column.setSpacing(2)
        column.addWidget(self.views, 1)
        for bar in (self.slice_bar, self.scale_bar, self.timeline):
            column.addWidget(bar)
        self.setCentralWidget(centre)

    def _make_docks(self) -> None:
        self.inspector = Inspector(self.session, self.stage)
        self.method_panel = MethodPanel(self.session, self.editor)
        self.items_panel = ItemsPanel(self.session, self.editor, self.add_menus)
        self.curves = CurvesPanel(self.session, self.stage)
        self.runs_panel = RunsPanel(self.session, self.stage)
        self.docks: dict[str, QDockWidget] = {}
        right, bottom = Qt.DockWidgetArea.RightDockWidgetArea, Qt.DockWidgetArea.LeftDockWidgetArea
        for title, widget, area in (
            ("Method", self.method_panel, bottom),
            ("Scene", self.items_panel, bottom),
            ("Cell", self.inspector, right),
            ("Energy and errors", self.curves, right),
            ("Kept runs", self.runs_panel, right),
        ):
            dock = QDockWidget(title, self)
            dock.setObjectName(title)
            dock.setWidget(widget)
            self.addDockWidget(area, dock)
            self.docks[title] = dock
        self.tabifyDockWidget(self.docks["Energy and errors"], self.docks["Kept runs"])
        self.tabifyDockWidget(self.docks["Method"], self.docks["Scene"])
        for name in ("Energy and errors", "Method"):
            self.docks[name].raise_()
        menu = self.menus["View"].addMenu("Docks")
        for dock in self.docks.values():
            menu.addAction(dock.toggleViewAction())
        sides = [self.docks["Method"], self.docks["Cell"]]
        self.resize(1360, 860)
        self.resizeDocks(sides, [290, 270], Qt.Orientation.Horizontal)

    def _bind(self) -> None:
        session = self.session
        session.framed.connect(self._show_frame)
        session.display.changed.connect(self._show_display)
        session.document.changed.connect(self._show_scene)
        session.document.renamed.connect(self.refresh_title)
        session.method_changed.connect(self._show_method)
        session.references_changed.connect(self._show_frame)
        session.runs_changed.connect(self._show_frame)
        session.tool_changed.connect(self.refresh_actions)
        session.busy_changed.connect(self.refresh_actions)
        session.selection.changed.connect(self._show_selection)
        session.failed.connect(self.controller.tell_failure)
        self.editor.stack.indexChanged.connect(self.refresh_actions)
        self.views.maximize_requested.connect(self.controller.one_view)

    # -- following the models -------------------------------------------------------------------

    def _show_frame(self) -> None:
        self.views.repaint_views()
        self.scale_bar.refresh()
        self._refresh_titles()

    def _show_display(self) -> None:
        self.views.arrange()
        self.slice_bar.refresh()
        self.scale_bar.refresh()
        self.inspector.refresh()
        self._refresh_titles()
        self.refresh_actions()

    def _show_scene(self) -> None:
        self.slice_bar.refresh()
        self.views.arrange()
        self.refresh_actions()

    def _show_method(self) -> None:
        self._refresh_titles()
        self.refresh_actions()

    def _show_selection(self) -> None:
        """The keys of what was picked come to the front, where they stand behind the method."""
        dock = self.docks["Scene"]
        if self.session.selection.items and dock in self.tabifiedDockWidgets(self.docks["Method"]):
            dock.raise_()
        self.refresh_actions()

    def _refresh_titles(self) -> None:
        frame = self.session.frame
        for view in self.session.display.look.views:
            self.views.set_title(view, view_title(view, frame, self.session))

    def refresh_title(self) -> None:
        document = self.session.document
        mark = "*" if document.dirty else ""
        self.setWindowTitle(f"{mark}{document.origin.name} – flatland")
        self.setWindowModified(False)

    def refresh_actions(self) -> None:
        self.controller.refresh_actions(self.actions_by_name)

    # -- layout, closing, dropping --------------------------------------------------------------

    def _restore_layout(self) -> None:
        for key, restore in (("geometry", self.restoreGeometry), ("layout", self._restore_docks)):
            stored = self.settings.stored_bytes(key)
            if stored:
                restore(QByteArray(stored))

    def _restore_docks(self, stored: QByteArray) -> bool:
        return self.restoreState(stored, LAYOUT_VERSION)

    def reset_layout(self) -> None:
        self.restoreState(self._first_state, LAYOUT_VERSION)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self.views.arrange()
        if self.focusWidget() is None:
            self.views.setFocus()

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        if not self.controller.may_close():
            event.ignore()
            return
        self.settings.store_bytes("geometry", bytes(self.saveGeometry().data()))
        self.settings.store_bytes("layout", bytes(self.saveState(LAYOUT_VERSION).data()))
        self.settings.keep_look(self.session.display.look)
        self.settings.save()
        self.shut_down()
        event.accept()

    def shut_down(self) -> None:
        """Stop threads and timers; the window may be dropped afterwards."""
        if self._shut:
            return
        self._shut = True
        # On its way out the stack still tells that it became empty.
        self.editor.stack.blockSignals(True)
        self.controller.closed()
        self.worker.close()
        self.reference_worker.close()
        self.keys.stop()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        for url in event.mimeData().urls():
            if url.isLocalFile():
                self.controller.open_scene(Path(url.toLocalFile()))
                break


def view_title(view: str, frame: object, session: Session) -> str:
    """What stands over a view."""
    name = view.capitalize()
    if view in ("reference", "difference"):
        return "Exact" if view == "reference" else "Accumulated − exact"
    if session.frame is None:
        return name
    if session.frame.converged is not None:
        return f"{name}, converged" if view == "accumulated" else f"{name}: nothing moves any more"
    if not session.choice.steps:
        return f"{name}, {session.choice.propagator}"
    return f"{name}, iteration {session.frame.iteration}"
