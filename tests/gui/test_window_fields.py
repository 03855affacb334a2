"""What is edited in fields: items, grid, medium, method, and the scene as text."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import do, settle

from flatland.medium import Medium
from flatland.scene import parse_scene
from propagators.registry import find


@pytest.mark.parametrize("name", ["light", "occluder"])
def test_every_kind_is_added_from_the_menu_and_edited_by_numbers(make, name):
    window = make()
    menu = window.add_menus[name]
    menu.aboutToShow.emit()
    kinds = [action.text() for action in menu.actions() if action.text() not in ("File", "Mesh")]
    assert len(kinds) >= 3
    for kind in kinds:
        next(action for action in menu.actions() if action.text() == kind).trigger()
        settle(window)
        assert window.told == []
        place = window.session.selection.items[0]
        item = getattr(window.session.scene, f"{name}s")[place[1]]
        assert item.kind == kind.lower()
        assert set(window.items_panel.controls) == {
            field.alias or key for key, field in type(item).model_fields.items() if key != "kind"
        }


def test_the_editor_changes_keys_and_refuses_nonsense(make):
    window = make("shelf")
    window.session.selection.set([("light", 0)])
    control = window.items_panel.controls["flux"]
    control.line.setText("7.5")
    control.line.editingFinished.emit()
    settle(window)
    assert window.session.scene.lights[0].flux == 7.5
    assert window.session.frame.accumulated.total_flux() == pytest.approx(7.5)
    control.line.setText("[1.0, 0.5, 0.25]")
    control.line.editingFinished.emit()
    settle(window)
    assert window.session.scene.colours == 3
    text = window.session.document.text
    for nonsense in ("-1", "abc", "[1, 2", "1e400"):
        control.line.setText(nonsense)
        control.line.editingFinished.emit()
        assert window.session.document.text == text
        assert "d5331f" in control.line.styleSheet()
    do(window, "undo")
    do(window, "undo")
    assert window.session.scene.lights[0].flux == 20.0


def test_the_grid_and_title_are_edited_too(make):
    window = make("shelf")
    assert set(window.items_panel.controls) == {
        "title", "shape", "spacing", "origin", "extinction", "albedo",
    }  # fmt: skip
    control = window.items_panel.controls["shape"]
    control.line.setText("[40, 32]")
    control.line.editingFinished.emit()
    settle(window)
    assert window.session.scene.grid.shape == (40, 32)
    control.line.setText("[8, 8]")
    control.line.editingFinished.emit()
    settle(window)
    assert window.session.scene.grid.shape == (40, 32)
    assert "must lie in the grid" in window.notices[-1]
    title = window.items_panel.controls["title"]
    title.line.setText('Two "words"')
    title.line.editingFinished.emit()
    assert window.session.scene.title == 'Two "words"'


def test_the_medium_is_edited_with_the_grid(make):
    window = make("shelf")
    for key, value in (("extinction", "0.3"), ("albedo", "0.9")):
        control = window.items_panel.controls[key]
        control.line.setText(value)
        control.line.editingFinished.emit()
        settle(window)
    assert window.session.scene.medium == Medium(0.3, 0.9)
    do(window, "undo")
    do(window, "undo")
    assert window.session.scene.medium is None
    assert "medium" not in window.session.document.text


def test_method_editors_come_from_the_declared_options(make):
    window = make()
    panel = window.method_panel
    assert set(panel.controls) == {
        "flux", "sample", "normalization", "amplifier", "clamp", "propagation_factor",
    }  # fmt: skip
    panel.controls["flux"].box.setCurrentIndex(1)
    settle(window)
    assert window.session.choice.options == {"flux": "central"}
    panel.controls["clamp"].box.setChecked(True)
    factor = panel.controls["propagation_factor"]
    factor.line.setText("0.5")
    factor.line.editingFinished.emit()
    settle(window)
    assert window.session.choice.method().propagator.values["propagation_factor"] == 0.5
    factor.line.setText("11")
    factor.line.editingFinished.emit()
    assert window.session.choice.options["propagation_factor"] == 0.5
    assert "at most 10" in factor.line.toolTip()
    panel.bands.setValue(2)
    panel.bands.setValue(3)
    settle(window)
    assert window.session.frame.accumulated.basis.bands == 3
    do(window, "undo")
    assert window.session.choice.bands == 4
    panel.precision.activated.emit(1)
    settle(window)
    assert window.session.frame.accumulated.values.dtype == np.float32
    panel._pick(panel.propagator.findText("analytic"))
    settle(window)
    assert set(panel.controls) == {option.name for option in find("analytic").options}
    assert not window.actions_by_name["step"].isEnabled()
    assert list(window.session.frame.fields) == ["accumulated"]


def test_the_scene_as_text(make, answers):
    window = make("shelf")
    answers["edit_scene"] = window.session.document.text.replace("32, 32", "36, 36")
    do(window, "edit_text_dialog")
    assert window.session.scene.grid.shape == (36, 36)
    do(window, "undo")
    assert window.session.scene.grid.shape == (32, 32)


def test_the_text_dialog_takes_valid_scenes_alone(qtbot):
    from gui.widgets.text_dialog import TextDialog

    dialog = TextDialog(None, "[grid]\nshape = [4, 4]\n", parse_scene)
    qtbot.addWidget(dialog)
    assert dialog.check()
    dialog.view.setPlainText("[grid]\nshape = [4, 0]\n")
    assert not dialog.check()
    assert "shape" in dialog.problems.text()
    dialog.accept()
    assert dialog.result() == 0
