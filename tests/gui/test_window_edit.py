"""The real window: drawing, dragging, selecting, undo."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import at_cell, do, drag
from PySide6.QtCore import Qt

from flatland.scene import parse_scene
from gui.models.tools import Tool

SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
RIGHT = Qt.MouseButton.RightButton


def test_a_drawn_stroke_is_cells_without_holes_and_one_undo(make, qtbot):
    window = make()
    window.session.set_tool(Tool.INJECT)
    before = window.session.document.text
    drag(qtbot, window, [(2, 5), (9, 12), (14, 12)])
    cells = [light.cell for light in window.session.scene.lights if light.kind == "cell"]
    assert np.abs(np.diff(cells, axis=0)).max() == 1
    assert (2, 5) in cells
    assert (14, 12) in cells
    assert window.session.iteration == 0
    assert window.session.frame.accumulated.total_flux() == pytest.approx(5 + len(cells))
    assert window.session.document.dirty
    assert window.windowTitle().startswith("*")
    do(window, "undo")
    assert window.session.document.text == before
    assert not window.windowTitle().startswith("*")
    do(window, "redo")
    assert len(window.session.scene.lights) == 1 + len(cells)


def test_an_occluder_is_drawn_and_erased_by_the_right_button(make, qtbot):
    window = make()
    window.session.set_tool(Tool.OCCLUDE)
    drag(qtbot, window, [(3, 8), (12, 8)], modifier=CTRL)
    wall = window.session.scene.occluders[0]
    assert wall.kind == "segment"
    assert wall.start == (3.5, 8.5)
    assert wall.end == (12.5, 8.5)
    drag(qtbot, window, [(8, 6), (8, 10)], button=RIGHT)
    assert window.session.scene.occluders == ()
    assert len(window.session.scene.lights) == 1
    do(window, "undo")
    assert len(window.session.scene.occluders) == 1


def test_shift_keeps_a_line_straight(make, qtbot):
    window = make()
    window.session.set_tool(Tool.OCCLUDE)
    drag(qtbot, window, [(3, 8), (12, 9)], modifier=SHIFT)
    wall = window.session.scene.occluders[0]
    assert wall.start[1] == pytest.approx(wall.end[1])


def test_select_move_and_drag_an_end(make, qtbot):
    window = make("shelf")
    window.session.set_tool(Tool.SELECT)
    canvas, on_wall = at_cell(window, 20, 15.5)
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=on_wall)
    assert window.session.selection.items == (("occluder", 0),)
    drag(qtbot, window, [(20, 15.5), (18, 13.5)], modifier=CTRL)
    wall = window.session.scene.occluders[0]
    assert wall.start == (10.0, 14.0)
    drag(qtbot, window, [(9.5, 13.5), (4.5, 20.5)], modifier=CTRL)
    wall = window.session.scene.occluders[0]
    assert wall.start == (5.0, 21.0)
    assert wall.end == (30.0, 14.0)
    do(window, "undo")
    do(window, "undo")
    assert window.session.scene.occluders[0].start == (12.0, 16.0)
    assert "# After the left picture" in window.session.document.text


def test_a_click_pins_a_cell_and_hover_tells_its_numbers(make, qtbot):
    window = make()
    do(window, "step_many")
    canvas, place = at_cell(window, 8, 5)
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place)
    assert window.session.selection.pinned == (8, 5)
    window.inspector.refresh()
    flux = window.session.frame.accumulated.scalar_flux()[8, 5]
    assert window.inspector.labels["Flux"].text() == f"{flux:.4g} W"
    assert window.inspector.plot.curves[0].values.max() > 0
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place)
    assert window.session.selection.pinned is None


def test_rectangle_selection_copy_paste_rotate_mirror(make, qtbot):
    window = make("cornell-2d")
    window.session.set_tool(Tool.SELECT)
    drag(qtbot, window, [(4, 21), (18, 0)])
    assert window.session.selection.items == (("occluder", 4),)
    do(window, "copy")
    do(window, "paste")
    assert len(window.session.scene.occluders) == 7
    assert window.session.selection.items == (("occluder", 6),)
    first, copy = (window.session.scene.occluders[i].vertices[0] for i in (4, 6))
    assert np.subtract(copy, first) == pytest.approx([1, -1])
    text = window.session.document.text
    for command in ("rotate_left", "rotate_right", "mirror_across", "mirror_across", "nudge_up"):
        do(window, command)
    do(window, "nudge_down")
    before, after = parse_scene(text), parse_scene(window.session.document.text)
    np.testing.assert_allclose(
        sorted(after.occluders[6].vertices), sorted(before.occluders[6].vertices), atol=1e-8
    )
    do(window, "cut")
    assert len(window.session.scene.occluders) == 6


def test_clear_lights_keeps_occluders_and_the_reverse(make):
    window = make("shelf")
    do(window, "clear_lights")
    assert (len(window.session.scene.lights), len(window.session.scene.occluders)) == (0, 1)
    do(window, "undo")
    do(window, "clear_occluders")
    assert (len(window.session.scene.lights), len(window.session.scene.occluders)) == (1, 0)


def test_select_all_and_delete(make):
    window = make("cornell-2d")
    do(window, "select_all")
    do(window, "delete")
    assert window.session.scene.lights == ()
    assert window.session.scene.occluders == ()
    do(window, "undo")
    assert len(window.session.scene.occluders) == 6


def test_pick_up_draws_more_of_the_same(make, qtbot):
    window = make("cornell-2d")
    window.session.set_tool(Tool.PICK_UP)
    canvas, place = at_cell(window, 10, 8)
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place)
    window.session.set_tool(Tool.OCCLUDE)
    drag(qtbot, window, [(20, 20), (24, 24)])
    new = window.session.scene.occluders[-1]
    assert new.kind == "polygon"
    assert new.albedo == (0.73, 0.71, 0.68)


def test_escape_drops_the_stroke_in_hand(make, qtbot):
    window = make()
    window.session.set_tool(Tool.INJECT)
    canvas, start = at_cell(window, 3, 3)
    qtbot.mousePress(canvas, Qt.MouseButton.LeftButton, pos=start)
    assert window.mouse.ghosts()
    window.actions_by_name["stop"].trigger()
    qtbot.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=start)
    assert len(window.session.scene.lights) == 1
