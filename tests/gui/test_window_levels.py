"""The real window on an octree: levels, what is merged from them, and filling them by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import do, settle

from studies.running import run_method


@pytest.fixture
def octree(make):
    window = make("two-walls")
    window.editor.edit_choice("Levels", replace(window.session.choice, bands=2, levels=3))
    settle(window)
    do(window, "step_many")
    return window


def test_the_merged_field_is_that_of_the_command_line(octree):
    session = octree.session
    run = run_method(session.scene, session.choice.method(iterations=10))
    np.testing.assert_array_equal(session.field("accumulated").values, run.accumulated.values)
    do(octree, "back")
    do(octree, "back_many")
    do(octree, "last")
    np.testing.assert_array_equal(session.field("accumulated").values, run.accumulated.values)


def test_every_level_is_looked_at_in_turn(octree):
    session, canvas = octree.session, octree.views.canvases["accumulated"]
    seen = []
    for level in range(3):
        do(octree, "level")
        assert session.level == level
        assert session.field("accumulated").grid.shape == (16 >> level, 16 >> level)
        seen.append(canvas.grab().toImage())
    assert len({image.constBits().tobytes() for image in seen}) == len(seen)
    do(octree, "level")
    assert session.level is None


def test_errors_are_told_per_level(octree):
    do(octree, "reference")
    values = octree.session.track.rows[10].values
    assert values["coefficients"] > 0
    assert all(f"mean_relative@{level}" in values for level in range(3))
    do(octree, "level")
    do(octree, "level")
    assert octree.session.field("difference").grid.shape == (8, 8)


def test_levels_are_filled_by_hand(octree):
    session = octree.session
    do(octree, "inject")
    assert not session.frame.levels[1]["accumulated"].values.any()
    do(octree, "step")
    do(octree, "downsample")
    assert session.frame.levels[1]["accumulated"].values.any()
    do(octree, "step")
    do(octree, "step")
    after = session.field("accumulated").values
    for iteration in (0, 3, 1, 3):
        session.go_to(iteration)
        settle(octree)
    np.testing.assert_array_equal(session.field("accumulated").values, after)


def test_too_many_levels_are_refused_with_a_message(octree):
    octree.method_panel.levels.setValue(12)
    settle(octree)
    assert any("levels = 12" in text for text in octree.notices)
    do(octree, "undo")
    assert octree.session.choice.levels == 3
