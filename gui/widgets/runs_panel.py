"""Runs that were kept: shown or hidden, and thrown away."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gui.models.session import Session
from gui.render.stage import Stage
from gui.widgets.blocking import quiet


class RunsPanel(QWidget):
    """A list with a tick for each kept run."""

    def __init__(self, session: Session, stage: Stage) -> None:
        super().__init__()
        self.session, self.stage = session, stage
        self.list = QListWidget()
        self.list.setAccessibleName("Kept runs")
        self.list.itemChanged.connect(self._ticked)
        self.hint = QLabel("K keeps the run on show, to draw it over the next ones.")
        self.hint.setWordWrap(True)
        self.remove = QPushButton("Remove")
        self.remove.clicked.connect(self._remove)
        self.list.currentRowChanged.connect(lambda row: self.remove.setEnabled(row >= 0))
        row = QHBoxLayout()
        row.addWidget(self.hint, 1)
        row.addWidget(self.remove)
        column = QVBoxLayout(self)
        column.setContentsMargins(4, 4, 4, 4)
        column.addWidget(self.list)
        column.addLayout(row)
        session.runs_changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        with quiet(self.list):
            self.list.clear()
            for run in self.session.runs:
                last = max(run.track.rows, default=0)
                item = QListWidgetItem(f"{run.label}, {last} iterations")
                swatch = QPixmap(12, 12)
                swatch.fill(QColor(self.stage.colour_of(run.scheme)))
                item.setIcon(QIcon(swatch))
                item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
                state = Qt.CheckState.Checked if run.visible else Qt.CheckState.Unchecked
                item.setCheckState(state)
                if run.field.grid != self.session.scene.grid:
                    item.setToolTip("of another grid: in the curves alone")
                self.list.addItem(item)
        self.remove.setEnabled(self.list.currentRow() >= 0)

    def _ticked(self, item: QListWidgetItem) -> None:
        index = self.list.row(item)
        shown = item.checkState() == Qt.CheckState.Checked
        self.session.runs[index] = replace(self.session.runs[index], visible=shown)
        # Later: the list may not be made anew while it tells of this item.
        QTimer.singleShot(0, self.session.runs_changed.emit)

    def _remove(self) -> None:
        if self.list.currentRow() >= 0:
            self.session.drop_run(self.list.currentRow())
