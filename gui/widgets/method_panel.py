"""The method: propagator, its declared options, bands, and what walls do."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QFrame,
    QLabel,
    QScrollArea,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from flatland.errors import InputError
from gui.models.choice import (
    BLOCKING,
    MOST_BANDS,
    PRECISION,
    Choice,
    level_options,
    propagators_for,
)
from gui.models.session import Session
from gui.models.toml_text import REMOVED
from gui.undo import Editor
from gui.widgets.blocking import quiet
from gui.widgets.values import ValueControl, option_control
from propagators.registry import find


class MethodPanel(QScrollArea):
    """Every change is one step of undo; the run starts anew with it."""

    def __init__(self, session: Session, editor: Editor) -> None:
        super().__init__()
        self.session, self.editor = session, editor
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.inner = inner = QWidget()
        column = QVBoxLayout(inner)
        column.setContentsMargins(6, 4, 6, 4)
        self.setWidget(inner)
        self.propagator = QComboBox()
        _may_shrink(self.propagator)
        self.propagator.activated.connect(self._pick)
        self.summary = QLabel()
        self.summary.setWordWrap(True)
        self.bands = QSpinBox()
        self.bands.setRange(1, MOST_BANDS)
        self.bands.setKeyboardTracking(False)
        self.bands.valueChanged.connect(lambda value: self._change("bands", value))
        self.levels = QSpinBox()
        self.levels.setRange(1, 12)
        self.levels.setKeyboardTracking(False)
        self.levels.setToolTip("Levels of the octree; 1 is the uniform grid")
        self.levels.valueChanged.connect(lambda value: self._change("levels", value))
        self.coefficients = QLabel()
        self.precision = self._words("precision", PRECISION)
        self.blocking = self._words("blocking", BLOCKING)
        self.strength = QDoubleSpinBox()
        self.strength.setRange(0, 100)
        self.strength.setSingleStep(0.1)
        self.strength.setKeyboardTracking(False)
        self.strength.valueChanged.connect(lambda value: self._change("strength", value))
        self.bounces = self._check("bounces", "off walls")
        self.lights_block = self._check("lights_block", "area lights do")
        form = _form()
        form.addRow("Propagator", self.propagator)
        form.addRow(self.summary)
        form.addRow("Bands", self.bands)
        form.addRow("", self.coefficients)
        self.options_form = _form()
        rest = _form()
        rest.addRow("Levels", self.levels)
        self.level_controls: dict[str, ValueControl] = {}
        for option in level_options():
            control = option_control(option)
            control.edited.connect(lambda value, name=option.name: self._level_option(name, value))
            rest.addRow(f"Level {option.name}", control)
            self.level_controls[option.name] = control
        rest.addRow("Precision", self.precision)
        rest.addRow("Blocking", self.blocking)
        rest.addRow("Strength", self.strength)
        rest.addRow("Bounces", self.bounces)
        rest.addRow("Lights block", self.lights_block)
        for part in (form, self.options_form, rest):
            column.addLayout(part)
        column.addStretch(1)
        self._tips()
        self.controls: dict[str, ValueControl] = {}
        self._built = ""
        session.method_changed.connect(self.refresh)
        session.document.changed.connect(self.refresh)
        self.refresh()

    def _tips(self) -> None:
        self.bands.setToolTip("Angular bands of every cell")
        self.precision.setToolTip("Precision of the fields")
        self.blocking.setToolTip(
            "What occluders do: cut beams exactly, through a geometry volume (fuzzy), or nothing"
        )
        self.bounces.setToolTip("Walls send light back by their albedo")
        self.lights_block.setToolTip("Area lights stop light from elsewhere, like black walls")
        self.strength.setToolTip("Factor on fuzzy blocking")

    def _words(self, name: str, words: tuple[str, ...]) -> QComboBox:
        box = QComboBox()
        _may_shrink(box)
        box.addItems(list(words))
        box.activated.connect(lambda index: self._change(name, words[index]))
        return box

    def _check(self, name: str, text: str) -> QCheckBox:
        box = QCheckBox(text)
        box.toggled.connect(lambda value: self._change(name, value))
        return box

    def refresh(self) -> None:
        """Show the session's choice."""
        choice, dimension = self.session.choice, self.session.scene.grid.dimension
        names = propagators_for(dimension)
        if names != [self.propagator.itemText(i) for i in range(self.propagator.count())]:
            self.propagator.clear()
            self.propagator.addItems(names)
        self.propagator.setCurrentIndex(names.index(choice.propagator))
        found = find(choice.propagator)
        self.summary.setText(found.summary)
        size = 2 * choice.bands - 1 if dimension == 2 else choice.bands**2
        self.coefficients.setText(f"{size} coefficients a cell")
        boxes = (self.bands, self.levels, self.strength, self.bounces, self.lights_block)
        with quiet(*boxes):
            self.bands.setValue(choice.bands)
            self.levels.setValue(choice.levels)
            self.strength.setValue(choice.strength)
            self.bounces.setChecked(choice.bounces)
            self.lights_block.setChecked(choice.lights_block)
        self.precision.setCurrentText(choice.precision)
        self.blocking.setCurrentText(choice.blocking)
        self.strength.setEnabled(choice.blocking == "fuzzy" and choice.steps)
        for control in (self.levels, self.precision, self.blocking, self.lights_block):
            control.setEnabled(choice.steps)
        self._show_options(choice)
        for name, editor in self.level_controls.items():
            editor.show_value(choice.octree.get(name))
            editor.setEnabled(choice.steps and choice.levels > 1)

    def _show_options(self, choice: Choice) -> None:
        found = find(choice.propagator)
        if self._built != choice.propagator:
            self._built = choice.propagator
            while self.options_form.rowCount():
                self.options_form.removeRow(0)
            self.controls = {}
            for option in found.options:
                control = option_control(option)
                control.edited.connect(lambda value, name=option.name: self._option(name, value))
                label = QLabel(option.name.replace("_", " ").capitalize())
                label.setToolTip(option.meaning)
                self.options_form.addRow(label, control)
                self.controls[option.name] = control
            self.setMinimumWidth(self.inner.minimumSizeHint().width() + 18)
        for option in found.options:
            self.controls[option.name].show_value(choice.options.get(option.name, option.default))

    # -- edits ----------------------------------------------------------------------------------

    def _pick(self, index: int) -> None:
        name = self.propagator.itemText(index)
        if name != self.session.choice.propagator:
            self._try(replace(self.session.choice, propagator=name, options={}), "propagator")

    def _change(self, name: str, value: Any) -> None:
        self._try(replace(self.session.choice, **{name: value}), name)

    def _option(self, name: str, value: Any) -> None:
        options = dict(self.session.choice.options)
        if value is REMOVED:
            options.pop(name, None)
        else:
            options[name] = value
        self._try(replace(self.session.choice, options=options), name)

    def _level_option(self, name: str, value: Any) -> None:
        octree = {key: old for key, old in self.session.choice.octree.items() if key != name}
        if value is not REMOVED:
            octree[name] = value
        self._try(replace(self.session.choice, octree=octree), name)

    def _try(self, choice: Choice, name: str) -> None:
        try:
            self.editor.edit_choice(f"Change {name.replace('_', ' ')}", choice, f"method {name}")
        except InputError as error:
            self.session.noticed.emit(str(error))
        self.refresh()


def _form() -> QFormLayout:
    form = QFormLayout()
    form.setContentsMargins(0, 0, 0, 4)
    form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
    form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.DontWrapRows)
    form.setVerticalSpacing(4)
    return form


def _may_shrink(box: QComboBox) -> None:
    """Narrower than its longest entry."""
    box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
    box.setMinimumContentsLength(6)
