"""Which layer of a 3D grid is looked at, and which level and colour."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QSizePolicy, QSlider, QWidget

from gui.models.session import Session
from gui.widgets.blocking import quiet


class SliceBar(QWidget):
    """Axis and layer; a colour channel where the scene has colours; hidden without either."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 2, 4, 2)
        self.slice = QWidget()
        inner = QHBoxLayout(self.slice)
        inner.setContentsMargins(0, 0, 0, 0)
        self.axis = QComboBox()
        self.axis.addItems(["x", "y", "z"])
        self.axis.setToolTip("The axis that is looked along")
        self.axis.currentIndexChanged.connect(self._turn)
        self.layer = QSlider(Qt.Orientation.Horizontal)
        self.layer.setToolTip("Layer of cells along that axis (PgUp, PgDown)")
        self.layer.setAccessibleName("Layer")
        self.layer.valueChanged.connect(lambda value: session.display.set(layer=value))
        self.number = QLabel()
        self.number.setMinimumWidth(150)
        inner.addWidget(QLabel("Slice across"))
        inner.addWidget(self.axis)
        inner.addWidget(self.layer, 1)
        inner.addWidget(self.number)
        row.addWidget(self.slice, 1)
        self.channel = QComboBox()
        self.channel.setToolTip("Colour channel of the light")
        self.channel.currentIndexChanged.connect(
            lambda index: session.display.set(channel=index - 1 if index > 0 else None)
        )
        self.channel.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.level = QComboBox()
        self.level.setToolTip("Level of the octree, or every cell from its finest lit level")
        self.level.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.level.currentIndexChanged.connect(
            lambda index: session.display.set(level=index - 1 if index > 0 else None)
        )
        row.addWidget(self.channel)
        row.addWidget(self.level)
        row.addStretch(0)
        session.method_changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        grid, colours = self.session.scene.grid, self.session.scene.colours
        plane = self.session.plane
        solid = plane.normal is not None
        self.slice.setVisible(solid)
        self.channel.setVisible(colours > 0)
        count = self.session.choice.levels
        self.level.setVisible(count > 1)
        self.setVisible(solid or colours > 0 or count > 1)
        with quiet(self.axis, self.layer, self.channel, self.level):
            levels = ["Merged", *(f"Level {i}" for i in range(count))]
            _fill(self.level, levels)
            level = self.session.display.look.level
            self.level.setCurrentIndex(0 if level is None or level >= count else level + 1)
            if plane.normal is not None:
                self.axis.setCurrentIndex(plane.normal)
                self.layer.setRange(0, grid.shape[plane.normal] - 1)
                self.layer.setValue(plane.layer)
                name = "xyz"[plane.normal]
                self.number.setText(f"{name} = {plane.layer}  ({plane.depth(grid):g} m)")
            names = ["All colours", *_channel_names(colours)]
            _fill(self.channel, names)
            channel = self.session.display.look.channel
            good = channel is not None and channel < colours
            self.channel.setCurrentIndex(channel + 1 if good and channel is not None else 0)

    def _turn(self, axis: int) -> None:
        self.session.display.set(normal=axis, layer=None)


def _fill(box: QComboBox, names: list[str]) -> None:
    if [box.itemText(i) for i in range(box.count())] != names:
        box.clear()
        box.addItems(names)


def _channel_names(colours: int) -> list[str]:
    if colours == 3:
        return ["Red", "Green", "Blue"]
    return [f"Channel {i + 1}" for i in range(colours)]
