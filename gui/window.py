"""The main window: puts models, worker, views and docks together."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QByteArray, Qt
from PySide6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QShowEvent,
)
from PySide6.QtWidgets import (
    QApplication,
    QMainWindow,
    QMenu,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from gui.autosave import AutoSave
from gui.controllers import Controller
from gui.docks import make_docks
from gui.keys import Keys
from gui.menus import make_actions, make_add_menus, make_menus
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
        self.recent_menu = QMenu("Open recent", self)
        self.recovery = AutoSave(self, state_folder)
        self.keys = Keys(self, self.views)
        self.actions_by_name = make_actions(self)
        self.menus = make_menus(self)
        self.add_menus = make_add_menus(self)
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
        self.docks = make_docks(self)
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
        self.views.refresh_titles()

    def _show_display(self) -> None:
        self.views.arrange()
        self.slice_bar.refresh()
        self.scale_bar.refresh()
        self.inspector.refresh()
        self.views.refresh_titles()
        self.refresh_actions()

    def _show_scene(self) -> None:
        self.slice_bar.refresh()
        self.views.arrange()
        self.refresh_actions()

    def _show_method(self) -> None:
        self.views.refresh_titles()
        self.refresh_actions()

    def _show_selection(self) -> None:
        """The keys of what was picked come to the front, where they stand behind the method."""
        dock = self.docks["Scene"]
        if self.session.selection.items and dock in self.tabifiedDockWidgets(self.docks["Method"]):
            dock.raise_()
        self.refresh_actions()

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
