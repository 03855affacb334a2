"""The views side by side, or one of them large."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QVBoxLayout, QWidget

from gui.models.camera import Camera
from gui.models.display import MEANINGS, VIEWS
from gui.models.session import Session
from gui.mouse import Mouse
from gui.widgets.canvas import Canvas
from gui.widgets.view_painter import ViewPainter


class ViewArea(QWidget):
    """A canvas with a title for every view that the display shows.

    `scaled`: what is drawn may have changed its fitted scale.
    """

    maximize_requested = Signal(str)

    def __init__(
        self, session: Session, camera: Camera, painter: ViewPainter, mouse: Mouse
    ) -> None:
        super().__init__()
        # Where the focus rests while keys are commands.
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.session, self.camera = session, camera
        self.canvases = {v: Canvas(v, session, camera, painter, mouse) for v in VIEWS}
        self._titles: dict[str, QLabel] = {}
        self._panels: dict[str, QWidget] = {}
        self._layout = QGridLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(3)
        for view in VIEWS:
            self._panels[view] = self._panel(view)
        self._shown: tuple[str, ...] = ()
        self._places: tuple[int, ...] = ()
        camera.changed.connect(self.repaint_views)
        session.selection.hover_changed.connect(self.repaint_views)
        session.selection.pin_changed.connect(self.repaint_views)
        session.selection.changed.connect(self.repaint_views)
        self.arrange()

    def _panel(self, view: str) -> QWidget:
        panel = QWidget()
        column = QVBoxLayout(panel)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        title = QLabel(view.capitalize())
        title.setToolTip(f"{MEANINGS[view]}. Double-click: this view alone, or all again")
        title.setAlignment(Qt.AlignmentFlag.AlignCenter)
        title.setContentsMargins(4, 2, 4, 2)
        title.installEventFilter(self)
        self._titles[view] = title
        column.addWidget(title)
        column.addWidget(self.canvases[view], 1)
        return panel

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.MouseButtonDblClick:
            for view, title in self._titles.items():
                if title is watched:
                    self.maximize_requested.emit(view)
                    return True
        return super().eventFilter(watched, event)

    def refresh_titles(self) -> None:
        for view in self.session.display.look.views:
            text = view_title(view, self.session)
            if self._titles[view].text() != text:
                self._titles[view].setText(text)

    def arrange(self) -> None:
        """Put the shown views where they are largest."""
        shown = self.session.display.look.views
        columns = self._columns(len(shown))
        places = (columns, *(VIEWS.index(view) for view in shown))
        if places != self._places:
            self._places = places
            for panel in self._panels.values():
                self._layout.removeWidget(panel)
                panel.setVisible(False)
            for row in range(3):
                self._layout.setRowStretch(row, 1 if row * columns < len(shown) else 0)
            for column in range(5):
                self._layout.setColumnStretch(column, 1 if column < columns else 0)
            for index, view in enumerate(shown):
                self._layout.addWidget(self._panels[view], *divmod(index, columns))
                self._panels[view].setVisible(True)
        self._shown = shown
        self.fit_if_wanted()
        self.repaint_views()

    def _columns(self, count: int) -> int:
        """How many views stand in a row so that a grid of this shape is largest."""
        nx, ny = self.session.plane.shape(self.session.scene.grid)
        width, height = max(self.width(), 1), max(self.height(), 1)

        def size(columns: int) -> float:
            rows = -(-count // columns)
            return min(width / columns / nx, (height / rows - 24) / ny)

        return max(range(1, count + 1), key=size)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self.arrange()

    def fit_if_wanted(self) -> None:
        """The whole grid in every view, until the user moves or zooms."""
        if self.camera.fitted and self._shown:
            self._layout.activate()
            sizes = [self.canvases[v].size() for v in self._shown]
            ratio = self.devicePixelRatioF()
            width = min(size.width() for size in sizes) * ratio
            height = min(size.height() for size in sizes) * ratio
            self.camera.fit(self.session.plane.shape(self.session.scene.grid), width, height)

    def repaint_views(self) -> None:
        for view in self.session.display.look.views:
            self.canvases[view].update()


def view_title(view: str, session: Session) -> str:
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
