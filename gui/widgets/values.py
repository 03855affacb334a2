"""One control per kind of value that a scene or a method declares."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QHBoxLayout,
    QLineEdit,
    QSpinBox,
    QToolButton,
    QWidget,
)

from flatland.scene.writing import tables_to_toml
from gui.models.fields import FieldSpec
from gui.models.toml_text import REMOVED, plain
from gui.widgets.blocking import quiet
from propagators.base import Option

#: Whole numbers beyond this are typed as text.
_LARGEST_SPIN = 2**31 - 1


class ValueControl(QWidget):
    """A control for one value. `edited` carries the new value, or REMOVED for its default.

    Bad input turns the text red, tells its rule in the tool tip, and is not sent.
    """

    edited = Signal(object)

    def __init__(self, spec: FieldSpec) -> None:
        super().__init__()
        self.spec = spec
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(0, 0, 0, 0)
        self._row.setSpacing(2)
        self.setToolTip(spec.meaning)

    def show_value(self, value: Any) -> None:
        """Show a value; None shows the default."""
        raise NotImplementedError


class TextControl(ValueControl):
    """Any TOML value as text: numbers, points, lists, colours."""

    def __init__(self, spec: FieldSpec) -> None:
        super().__init__(spec)
        self.line = QLineEdit()
        self.line.setAccessibleName(spec.key)
        self.line.setMinimumWidth(48)
        self.line.editingFinished.connect(self._finished)
        self._row.addWidget(self.line)
        self._shown = ""

    def show_value(self, value: Any) -> None:
        text = "" if value is None else toml_value(value)
        self._shown = text
        default = "" if self.spec.default is None else toml_value(self.spec.default)
        self.line.setPlaceholderText(default or ("" if self.spec.required else "not set"))
        if not self.line.hasFocus() or self.line.text() != text:
            self.line.setText(text)
        self._mark("")

    def _finished(self) -> None:
        text = self.line.text().strip()
        if text == self._shown:
            self._mark("")
            return
        if not text and not self.spec.required:
            self._shown = text
            self.edited.emit(REMOVED)
            return
        try:
            value = self._read(text)
            if self.spec.check is not None:
                self.spec.check(value)
        except (ValueError, TypeError) as error:
            self._mark(str(error))
            return
        self._shown = text
        self._mark("")
        self.edited.emit(plain(value))

    def _read(self, text: str) -> Any:
        if self.spec.kind in ("text", "file"):
            return text
        try:
            return tomllib.loads(f"x = {text}")["x"]
        except tomllib.TOMLDecodeError:
            raise ValueError(f"{text!r} is no value: numbers, or lists as [1.0, 2.0]") from None

    def _mark(self, problem: str) -> None:
        self.line.setStyleSheet("color: #d5331f" if problem else "")
        self.line.setToolTip(problem or self.spec.meaning)


class WholeControl(ValueControl):
    """A whole number with arrows."""

    def __init__(self, spec: FieldSpec, low: int = 0, high: int = _LARGEST_SPIN) -> None:
        super().__init__(spec)
        self.box = QSpinBox()
        self.box.setRange(low, high)
        self.box.setKeyboardTracking(False)
        self.box.setAccessibleName(spec.key)
        self.box.valueChanged.connect(self.edited.emit)
        self._row.addWidget(self.box)

    def show_value(self, value: Any) -> None:
        with quiet(self.box):
            shown = self.spec.default if value is None else value
            self.box.setValue(int(shown or 0))


class TruthControl(ValueControl):
    """Yes or no."""

    def __init__(self, spec: FieldSpec) -> None:
        super().__init__(spec)
        self.box = QCheckBox()
        self.box.setAccessibleName(spec.key)
        self.box.toggled.connect(self.edited.emit)
        self._row.addWidget(self.box)
        self._row.addStretch(1)

    def show_value(self, value: Any) -> None:
        with quiet(self.box):
            self.box.setChecked(bool(self.spec.default if value is None else value))


class ChoiceControl(ValueControl):
    """One of some words."""

    def __init__(self, spec: FieldSpec) -> None:
        super().__init__(spec)
        self.box = QComboBox()
        self.box.setAccessibleName(spec.key)
        self.box.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.box.setMinimumContentsLength(6)
        self.box.addItems([str(choice) for choice in spec.choices])
        self.box.currentIndexChanged.connect(lambda i: self.edited.emit(spec.choices[i]))
        self._row.addWidget(self.box)

    def show_value(self, value: Any) -> None:
        shown = self.spec.default if value is None else value
        with quiet(self.box):
            if shown in self.spec.choices:
                self.box.setCurrentIndex(self.spec.choices.index(shown))


class FileControl(TextControl):
    """The name of a data file, typed or looked for."""

    #: Asks for a file; replaced by tests.
    ask: Callable[[QWidget], str] | None = None

    def __init__(self, spec: FieldSpec) -> None:
        super().__init__(spec)
        self.button = QToolButton()
        self.button.setText("…")
        self.button.setToolTip("Look for a .npy or .npz file")
        self.button.clicked.connect(self._look)
        self._row.addWidget(self.button)

    def _look(self) -> None:
        from PySide6.QtWidgets import QFileDialog

        ask = type(self).ask
        if ask is not None:
            name = ask(self)
        else:
            name, _ = QFileDialog.getOpenFileName(self, "Data file", "", "Data (*.npy *.npz)")
        if name:
            self.line.setText(name)
            self._finished()

    def show_value(self, value: Any) -> None:
        super().show_value(None if value is None else value)
        if isinstance(value, str):
            self._shown = value
            self.line.setText(value)


def control_for(spec: FieldSpec) -> ValueControl:
    """The control of a kind of value; text for kinds without one of their own."""
    if spec.kind == "whole" and not spec.optional:
        return WholeControl(spec)
    kinds: dict[str, type[ValueControl]] = {
        "truth": TruthControl,
        "choice": ChoiceControl,
        "file": FileControl,
    }
    return kinds.get(spec.kind, TextControl)(spec)


def option_control(option: Option) -> ValueControl:
    """The control of a propagator's option."""

    def check(value: Any) -> Any:
        return option.check(value)

    kind = {bool: "truth", int: "whole", float: "number", str: "text"}[option.type]
    if option.choices:
        kind = "choice"
    spec = FieldSpec(
        option.name, kind, option.meaning, False, option.default, option.choices, check
    )
    if kind == "whole":
        low = -_LARGEST_SPIN if option.minimum is None else int(option.minimum)
        high = _LARGEST_SPIN if option.maximum is None else int(option.maximum)
        return WholeControl(spec, low, high)
    return control_for(spec)


def toml_value(value: Any) -> str:
    """A value as TOML text; bare text stays bare."""
    if isinstance(value, str):
        return value
    return tables_to_toml({"x": plain(value)}).partition(" = ")[2].strip()
