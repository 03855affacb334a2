"""The scale of the lobes: linear or logarithmic, fitted or set by hand."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QSizePolicy,
    QSlider,
    QToolButton,
    QWidget,
)

from gui.models.display import SCALES, SPREADS
from gui.render.stage import Stage
from gui.widgets.blocking import quiet

#: The slider counts hundredths of a decade, this many decades up and down from one.
_DECADES, _PER_DECADE = 12, 100


class ScaleBar(QWidget):
    """Slider and number are the intensity whose lobe reaches the side of its cell.

    Moving either turns `fit` off; only `fit` turns it on again.
    """

    def __init__(self, stage: Stage) -> None:
        super().__init__()
        self.stage, self.display = stage, stage.session.display
        self.kind = QComboBox()
        self.kind.addItems([name.capitalize() for name in SCALES])
        self.kind.setToolTip("Sizes of lobes: in proportion to the light, or by its logarithm")
        self.kind.currentIndexChanged.connect(lambda i: self.display.set(scale=SCALES[i]))
        self.decades = QDoubleSpinBox()
        self.decades.setRange(0.5, 16)
        self.decades.setSingleStep(0.5)
        self.decades.setDecimals(1)
        self.decades.setSuffix(" dec")
        self.decades.setToolTip("Logarithmic: light this many powers of ten below is a point")
        self.decades.valueChanged.connect(lambda value: self.display.set(decades=value))
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(-_DECADES * _PER_DECADE, _DECADES * _PER_DECADE)
        self.slider.setPageStep(_PER_DECADE)
        self.slider.setSingleStep(5)
        self.slider.setMinimumWidth(50)
        self.slider.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.slider.setAccessibleName("Scale")
        self.slider.valueChanged.connect(self._slid)
        self.number = QLineEdit()
        self.number.setFixedWidth(76)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.number.setAccessibleName("Intensity of a full lobe")
        self.number.editingFinished.connect(self._typed)
        self.unit = QLabel()
        self.fit = QToolButton()
        self.fit.setText("Fit")
        self.fit.setCheckable(True)
        self.fit.setToolTip("Follow the brightest light. A scale set by hand stays until then")
        self.fit.clicked.connect(self._fit)
        self.spread = QComboBox()
        self.spread.addItems([name.capitalize() for name in SPREADS])
        for index, meaning in enumerate(SPREADS.values()):
            self.spread.setItemData(index, meaning, Qt.ItemDataRole.ToolTipRole)
        self.spread.setToolTip("Shared: one scale for all views")
        self.spread.currentIndexChanged.connect(self._spread)
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 2, 4, 2)
        row.addWidget(QLabel("Scale"))
        for each in (self.kind, self.decades, self.slider, self.number, self.unit):
            row.addWidget(each)
        row.addWidget(self.fit)
        row.addWidget(self.spread)
        self.refresh()

    def refresh(self) -> None:
        """Show what the display says, the fitted scale included."""
        look = self.display.look
        grid = self.stage.session.scene.grid
        controls = (self.kind, self.decades, self.slider, self.number, self.fit, self.spread)
        with quiet(*controls):
            self.kind.setCurrentIndex(SCALES.index(look.scale))
            self.decades.setValue(look.decades)
            self.decades.setVisible(look.scale == "logarithmic" and look.spread != "per cell")
            self.fit.setChecked(look.top is None)
            self.spread.setCurrentIndex(list(SPREADS).index(look.spread))
            free = look.spread == "shared"
            for control in (self.slider, self.number, self.fit):
                control.setEnabled(free)
            top = self.stage.top("accumulated")
            if not self.slider.isSliderDown():
                self.slider.setValue(round(math.log10(top) * _PER_DECADE))
            if not self.number.hasFocus():
                self.number.setText(f"{top:.4g}")
            unit = "W/rad" if grid.dimension == 2 else "W/sr"
            self.unit.setText(unit)
            tip = f"Intensity [{unit}] whose lobe reaches the side of its cell"
            self.slider.setToolTip(tip)
            self.number.setToolTip(tip)

    def _slid(self, value: int) -> None:
        self.display.set(top=10.0 ** (value / _PER_DECADE))

    def _typed(self) -> None:
        try:
            top = float(self.number.text())
        except ValueError:
            top = float("nan")
        if 1e-30 < top < 1e30:
            if f"{top:.4g}" != f"{self.stage.top('accumulated'):.4g}":
                self.display.set(top=top)
        else:
            self.number.clearFocus()
            self.refresh()

    def _fit(self, wanted: bool) -> None:
        self.display.set(top=None if wanted else self.stage.top("accumulated"))

    def _spread(self, index: int) -> None:
        name = list(SPREADS)[index]
        self.spread.setToolTip(f"{name.capitalize()}: {SPREADS[name]}")
        self.display.set(spread=name)
