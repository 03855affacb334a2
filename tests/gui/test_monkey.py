"""A seeded monkey at the window: whatever it does, the window and a valid scene stay."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import at_cell, move, settle
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QLineEdit, QSpinBox

from flatland.scene import builtin_names, parse_scene
from gui.actions import COMMANDS

#: What a monkey may not do: close the window.
FORBIDDEN = {"quit"}
TYPED = (
    "0",
    "-1",
    "3",
    "0.5",
    "[1.0, 2.0]",
    "[3, 4]",
    "abc",
    "[[1, 2], [3, 4], [5, 1]]",
    "1e9",
    "",
)
MODIFIERS = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.ShiftModifier,
)


class Monkey:
    """Does one thing after another, chosen by a generator."""

    def __init__(self, window, qtbot, answers, tmp_path, seed):
        self.window, self.qtbot, self.answers = window, qtbot, answers
        self.rng = np.random.default_rng(seed)
        self.folder = tmp_path
        self.log = []
        (tmp_path / "bad.toml").write_text("[grid]\nshape = [0]\n", encoding="utf-8")

    def pick(self, options):
        return options[int(self.rng.integers(len(options)))]

    def act(self):
        ways = (self.command, self.command, self.command, self.stroke, self.click, self.type_value,
                self.control, self.wheel, self.resize, self.wait)  # fmt: skip
        way = self.pick(ways)
        self.log.append(way.__name__)
        way()

    def command(self):
        names = [c for c in COMMANDS if c.name not in FORBIDDEN]
        command = self.pick(names)
        name = f"{command.name}:{command.argument}" if command.argument else command.name
        self.log[-1] = name
        ending = self.pick(("toml", "png", "svg", "nc", "csv", "gif", "xyz"))
        self.answers["save_path"] = self.pick((None, self.folder / f"file.{ending}"))
        self.answers["open_path"] = self.pick((None, self.folder / "bad.toml", self.folder))
        self.answers["gallery"] = self.pick((None, *builtin_names()))
        self.answers["ask_save"] = self.pick(("drop", "stay", "save"))
        text = self.window.session.document.text
        self.answers["edit_scene"] = self.pick((None, text + "\n# more\n", "nonsense"))
        action = self.window.actions_by_name[name]
        if action.isEnabled():
            action.trigger()
        self.calm()

    def calm(self):
        """Monkeys choose large scenes; these may not take the whole day."""
        popup = QApplication.activePopupWidget() or QApplication.activeModalWidget()
        if popup is not None:
            popup.close()
        session = self.window.session
        if session.choice.bands > 6:
            self.window.method_panel.bands.setValue(2)

    def place(self):
        view = self.pick(self.window.session.display.look.views)
        canvas = self.window.views.canvases[view]
        spot = QPoint(
            *(int(self.rng.integers(max(n, 1))) for n in (canvas.width(), canvas.height()))
        )
        return canvas, spot

    def stroke(self):
        canvas, spot = self.place()
        button = self.pick((Qt.MouseButton.LeftButton, Qt.MouseButton.LeftButton,
                            Qt.MouseButton.RightButton, Qt.MouseButton.MiddleButton))  # fmt: skip
        modifier = self.pick(MODIFIERS)
        self.qtbot.mousePress(canvas, button, modifier, spot)
        for _ in range(int(self.rng.integers(1, 5))):
            spot = self.place()[1]
            move(canvas, spot, button, modifier)
            if self.rng.random() < 0.1:
                self.command()
        if self.rng.random() < 0.9:
            self.qtbot.mouseRelease(canvas, button, modifier, spot)

    def click(self):
        canvas, spot = self.place()
        self.qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, self.pick(MODIFIERS), spot)

    def type_value(self):
        lines = [line for line in self.window.findChildren(QLineEdit) if line.isVisible()]
        if lines:
            line = self.pick(lines)
            line.setText(self.pick(TYPED))
            line.editingFinished.emit()
        self.calm()

    def control(self):
        kinds = (QComboBox, QCheckBox, QSpinBox)
        found = [w for kind in kinds for w in self.window.findChildren(kind) if w.isVisible()]
        found = [w for w in found if w.isEnabled()]
        if not found:
            return
        widget = self.pick(found)
        if isinstance(widget, QComboBox) and widget.count():
            index = int(self.rng.integers(widget.count()))
            widget.setCurrentIndex(index)
            widget.activated.emit(index)
        elif isinstance(widget, QCheckBox):
            widget.click()
        elif isinstance(widget, QSpinBox):
            widget.setValue(int(self.rng.integers(1, 9)))
        self.calm()

    def wheel(self):
        canvas, spot = self.place()
        clicks = int(self.rng.integers(-4, 5))
        event = QWheelEvent(
            QPointF(spot), QPointF(canvas.mapToGlobal(spot)), QPoint(), QPoint(0, 120 * clicks),
            Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase,
            False,
        )  # fmt: skip
        QApplication.sendEvent(canvas, event)

    def resize(self):
        self.window.resize(int(self.rng.integers(400, 1500)), int(self.rng.integers(300, 1000)))

    def wait(self):
        QApplication.processEvents()


def let_loose(make, qtbot, answers, tmp_path, seed, count):
    window = make("fig5-one-light")
    monkey = Monkey(window, qtbot, answers, tmp_path, seed)
    for number in range(count):
        monkey.act()
        if number % 7 == 0:
            QApplication.processEvents()
        faults = [text for title, text in window.told if "fault" in title.lower()]
        assert not faults, (monkey.log[-5:], faults)
    window.mouse.drop()
    window.session.cancel()
    window.session.reference.stop()
    settle(window, 120)
    assert window.isVisible()
    document = window.session.document
    assert parse_scene(document.text, directory=document.origin.directory) == document.scene
    while window.editor.stack.canUndo():
        window.editor.stack.undo()
    while window.editor.stack.canRedo():
        window.editor.stack.redo()
    settle(window, 120)
    canvas, _ = at_cell(window, 0, 0, window.session.display.look.views[0])
    assert not canvas.grab().isNull()


def test_two_hundred_random_actions_do_no_harm(make, qtbot, answers, tmp_path):
    let_loose(make, qtbot, answers, tmp_path, 20100219, 200)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_two_thousand_random_actions_do_no_harm(make, qtbot, answers, tmp_path, seed):
    let_loose(make, qtbot, answers, tmp_path, seed, 2000)
