"""The real window: running, going back, comparing."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import do, settle, wait_until

from gui.actions import COMMANDS
from studies.reference import Reference
from studies.running import run_method


def test_it_opens_with_the_light_injected(make):
    window = make("shelf")
    assert window.session.iteration == 0
    assert window.session.frame.accumulated.total_flux() == pytest.approx(20.0)
    assert "shelf" in window.windowTitle()
    assert window.told == []


def test_steps_give_the_numbers_of_the_command_line(make):
    window = make("shelf")
    for _ in range(3):
        do(window, "step")
    do(window, "step_many")
    assert window.session.iteration == 13
    run = run_method(window.session.scene, window.session.choice.method(iterations=13))
    shown = window.session.frame.accumulated.values
    np.testing.assert_array_equal(shown, run.accumulated.values)


def test_the_copied_command_gives_the_same_numbers(make, tmp_path):
    import json
    import shlex

    from click.testing import CliRunner
    from PySide6.QtGui import QGuiApplication

    from studies.command_line import flatland

    window = make("fig5-one-light")
    do(window, "step_many")
    do(window, "copy_command")
    words = shlex.split(QGuiApplication.clipboard().text())
    assert words[:3] == ["flatland", "run", "fig5-one-light"]
    result = CliRunner().invoke(flatland, [*words[1:], "--json"])
    printed = json.loads(result.stdout)
    books = {name: float(value) for name, value in window.session.frame.ledger.as_dict().items()}
    for name in ("emitted", "left", "inside"):
        assert printed["ledger"][name] == pytest.approx(books[name], rel=1e-12, abs=1e-15)


def test_the_timeline_goes_back_and_forth(make):
    window = make()
    do(window, "step_many")
    after = window.session.frame.accumulated.values
    do(window, "back")
    assert window.session.iteration == 9
    window.timeline.slider.setValue(4)
    settle(window)
    assert window.session.iteration == 4
    assert window.timeline.number.text() == "4 / 10"
    do(window, "first")
    assert window.session.iteration == 0
    do(window, "last")
    np.testing.assert_array_equal(window.session.frame.accumulated.values, after)
    do(window, "back_many")
    assert window.session.iteration == 0


def test_run_goes_on_until_paused(make):
    window = make("shelf")
    window.session.display.set(rate=None)
    window.actions_by_name["run"].trigger()
    wait_until(lambda: window.session.iteration > 3)
    assert window.actions_by_name["run"].text() == "Pause"
    window.actions_by_name["run"].trigger()
    settle(window)
    assert window.actions_by_name["run"].text() == "Run"
    stopped = window.session.iteration
    settle(window)
    assert window.session.iteration == stopped
    assert window.session.last_iteration == stopped


def test_a_run_of_n_does_n(make):
    window = make()
    window.timeline.count.setValue(57)
    do(window, "run_count")
    assert window.session.iteration == 57
    assert window.session.track.series("inside")[0] == list(range(58))


def test_the_pace_is_kept(make):
    import time

    window = make()
    window.session.display.set(rate=50.0)
    begin = time.monotonic()
    window.actions_by_name["run"].trigger()
    wait_until(lambda: window.session.iteration >= 10)
    assert time.monotonic() - begin >= 9 / 50
    do(window, "stop")
    do(window, "faster")
    assert window.session.display.look.rate == 60.0
    do(window, "slower")
    do(window, "slower")
    assert window.session.display.look.rate == 20.0 or window.session.display.look.rate == 30.0


def test_converge_shows_the_solved_field_and_goes_back(make):
    window = make("shelf")
    do(window, "step_many")
    do(window, "solve")
    frame = window.session.frame
    assert frame.converged.residual <= 1e-8
    assert window.timeline.number.text() == "∞ / 10"
    do(window, "back")
    assert (window.session.iteration, window.session.frame.converged) == (10, None)


def test_the_exact_answer_and_its_errors(make):
    window = make()
    do(window, "step_many")
    do(window, "reference")
    exact = Reference(window.session.scene).field(window.session.choice.bands)
    np.testing.assert_allclose(window.session.exact.values, exact.values, rtol=1e-12)
    iterations, errors = window.session.track.series("coefficients")
    assert iterations == list(range(11))
    assert errors[10] < errors[0]
    do(window, "view:difference")
    difference = window.session.field("difference").values
    np.testing.assert_allclose(
        difference, window.session.frame.accumulated.values - exact.values, atol=1e-15
    )


def test_kept_runs_stay_and_go(make):
    window = make()
    do(window, "step_many")
    do(window, "keep")
    window.method_panel.propagator.setCurrentText("dom8")
    window.method_panel._pick(window.method_panel.propagator.currentIndex())
    settle(window)
    assert window.session.choice.propagator == "dom8"
    assert window.session.iteration == 0
    assert [run.scheme for run in window.session.overlays()] == ["lpv"]
    window.runs_panel.list.item(0).setCheckState(
        window.runs_panel.list.item(0).checkState().Unchecked
    )
    settle(window)
    assert window.session.overlays() == []
    window.runs_panel.list.setCurrentRow(0)
    window.runs_panel.remove.click()
    assert window.session.runs == []


def test_results_of_another_scene_are_dropped(make):
    window = make("shelf")
    window.session.display.set(rate=None)
    window.actions_by_name["run"].trigger()
    wait_until(lambda: window.session.iteration > 2)
    window.session.document.load("fig5-one-light")
    settle(window)
    assert window.session.frame.accumulated.grid.shape == (17, 17)
    assert window.session.iteration == 0
    assert max(window.session.track.rows) == 0


def test_reset_and_inject(make):
    window = make()
    do(window, "step")
    do(window, "reset")
    assert window.session.frame is None
    do(window, "inject")
    assert window.session.iteration == 0
    do(window, "downsample")
    do(window, "merge")
    assert "one level" in window.notices[-1]


def test_an_unstable_run_is_told_in_the_status_bar(make):
    from dataclasses import replace

    window = make()
    choice = replace(
        window.session.choice, propagator="dom4", options={"emission": "delta"}, bands=3
    )
    window.editor.edit_choice("Change", choice)
    settle(window)
    assert any("unstable" in text for text in window.notices)
    window.timeline.count.setValue(3000)
    do(window, "run_count")
    frame = window.session.frame
    assert frame.unstable_at is not None
    assert str(frame.unstable_at) in window.status.unstable.text()
    do(window, "back_many")
    assert window.session.frame.unstable_at is None


def test_closing_while_running_asks_and_ends_the_thread(make, answers):
    window = make("shelf")
    window.actions_by_name["run"].trigger()
    wait_until(lambda: window.session.busy == "run")
    answers["sure"] = False
    window.close()
    assert window.isVisible()
    answers["sure"] = True
    window.close()
    assert not window.isVisible()
    assert not window.worker.isRunning()


def test_every_command_has_a_method_a_tip_and_keys_of_its_own(make):
    window = make(shown=False)
    keys = [key for command in COMMANDS for key in command.keys]
    assert len(keys) == len(set(keys))
    for command in COMMANDS:
        assert callable(getattr(window.controller, command.name))
        name = f"{command.name}:{command.argument}" if command.argument else command.name
        assert window.actions_by_name[name].toolTip()


def test_an_idle_window_draws_nothing(make, qtbot):
    window = make("shelf")
    do(window, "step_many")
    qtbot.wait(200)
    before = (
        [canvas.painted for canvas in window.views.canvases.values()],
        window.curves.plot.painted,
    )
    qtbot.wait(700)
    after = (
        [canvas.painted for canvas in window.views.canvases.values()],
        window.curves.plot.painted,
    )
    assert before == after


def test_twenty_thousand_updates_do_no_harm(make):
    """PySide6 6.12.0 drops references to None and aborts after about 5,000 calls."""
    from PySide6.QtWidgets import QApplication

    canvas = make().views.canvases["accumulated"]
    for number in range(20_000):
        canvas.update()
        if number % 500 == 0:
            QApplication.processEvents()
    assert canvas.isVisible()


def test_an_exact_answer_that_was_stopped_can_be_asked_for_again(make):
    window = make("shelf")
    for _ in range(3):
        window.session.reference.compute()
        window.session.reference.stop()
    settle(window)
    assert not window.session.reference.computing
    assert window.session.exact is None
    do(window, "reference")
    assert window.session.exact is not None


def test_closing_does_not_wait_for_the_exact_answer(make):
    import time

    window = make("cornell-2d")
    window.session.reference.compute()
    wait_until(lambda: window.reference_worker.waiting > 0)
    begin = time.monotonic()
    window.close()
    assert time.monotonic() - begin < 3
    assert not window.reference_worker.isRunning()
