"""The cell under the mouse, or the pinned one: numbers and a polar plot."""

from __future__ import annotations

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QComboBox, QFormLayout, QLabel, QVBoxLayout, QWidget

from gui.models.display import VIEWS
from gui.models.levels import ratio_of
from gui.models.probe import Probe, probe, told
from gui.models.session import Session
from gui.render.stage import Stage
from gui.widgets.polar import Curve, PolarPlot

_ROWS = ("Cell", "Flux", "Net flux", "Smallest", "Largest", "Exact flux", "Coefficients")
#: Coefficients told one by one.
_MOST = 9


class Inspector(QWidget):
    """A click pins a cell; while the mouse is over another, that one is shown."""

    def __init__(self, session: Session, stage: Stage) -> None:
        super().__init__()
        self.session, self.stage = session, stage
        self.view = QComboBox()
        self.view.addItems([view.capitalize() for view in VIEWS])
        self.view.setCurrentIndex(VIEWS.index("accumulated"))
        self.view.setToolTip("Which grid the numbers are of")
        self.view.currentIndexChanged.connect(self.refresh)
        self.plot = PolarPlot()
        self.labels = {name: QLabel("–") for name in _ROWS}
        form = QFormLayout()
        form.setVerticalSpacing(2)
        form.setContentsMargins(6, 0, 6, 4)
        for name, label in self.labels.items():
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            label.setWordWrap(name == "Coefficients")
            form.addRow(name, label)
        self.labels["Net flux"].setToolTip("Size and vector of the flux that leaves the cell")
        column = QVBoxLayout(self)
        column.setContentsMargins(4, 4, 4, 2)
        column.addWidget(self.view)
        column.addWidget(self.plot, 1)
        column.addLayout(form)
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.setInterval(15)
        self._later.timeout.connect(self.refresh)
        for event in (
            session.selection.hover_changed,
            session.selection.pin_changed,
            session.framed,
            session.references_changed,
            session.runs_changed,
        ):
            event.connect(self._soon)
        self.refresh()

    def _soon(self) -> None:
        """Once, however many things change at a time."""
        if not self._later.isActive():
            self._later.start()

    def refresh(self) -> None:
        session, view = self.session, VIEWS[self.view.currentIndex()]
        cell = session.selection.hovered or session.selection.pinned
        field = session.field(view)
        shape = session.scene.grid.shape
        good = cell is not None and len(cell) == len(shape)
        if not good or cell is None or any(i >= n for i, n in zip(cell, shape)) or field is None:
            self._clear("point at a cell" if field is not None else "no light yet")
            return
        channel, plane = session.display.look.channel, session.plane_on(field.grid)
        ratio = ratio_of(field.grid, session.scene.grid)
        cell = tuple(i // ratio for i in cell)
        found = probe(field, cell, plane, channel)
        self._tell(found)
        curves = [Curve(view, found.curve, self.stage.colour_of(session.choice.propagator))]
        reference = session.field("reference")
        if reference is not None and view == "accumulated":
            exact = probe(reference, cell, plane, channel)
            curves.insert(0, Curve("exact", exact.curve, self.stage.palette.exact, True))
            self.labels["Exact flux"].setText(" ".join(f"{x:.4g}" for x in exact.flux) + " W")
        if view == "accumulated":
            for run in session.overlays():
                if run.field.grid.dimension == len(cell):
                    other = probe(run.field, cell, plane, channel)
                    colour = self.stage.colour_of(run.scheme)
                    curves.append(Curve(run.label, other.curve, colour))
        self.plot.negative = self.stage.palette.negative
        self.plot.show_curves(curves, "W/rad" if len(cell) == 2 else "W/sr")

    def _tell(self, found: Probe) -> None:
        for name, text in told(found, len(found.cell)):
            self.labels[name].setText(text)
        self.labels["Exact flux"].setText("–")
        few = found.coefficients[:_MOST]
        text = ", ".join(f"{x:.3g}" for x in few)
        self.labels["Coefficients"].setText(
            text + (", …" if len(found.coefficients) > _MOST else "")
        )

    def _clear(self, hint: str) -> None:
        for label in self.labels.values():
            label.setText("–")
        self.labels["Cell"].setText(hint)
        self.plot.hint = hint
        self.plot.show_curves([], "")
