"""The engine steps as the simulation does, and any iteration comes back exactly."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import assert_same_state, scene_of

import propagators
from flatland import Simulation, load_scene
from flatland.snapshots import capture, restore
from gui.models.choice import Choice
from gui.models.engine import Engine
from gui.models.frame import frame_of
from gui.models.history import History
from gui.models.jobs import Cancelled, Job
from gui.models.measures import errors_of
from studies import metrics
from studies.reference import Reference
from studies.running import run_method


class Ear:
    """A watch that remembers."""

    def __init__(self, cancel_after=None):
        self.frames, self.rows, self.notices = [], [], []
        self.calls, self.cancel_after = 0, cancel_after

    def cancelled(self):
        self.calls += 1
        return self.cancel_after is not None and self.calls > self.cancel_after

    def sleep(self, seconds):
        return

    def publish(self, frame, rows):
        self.frames.append(frame)
        self.rows += rows

    def progress(self, done, total):
        return

    def notice(self, text):
        self.notices.append(text)


def perform(engine, kind, choice, scene, ear=None, **arguments):
    ear = ear or Ear()
    engine.perform(Job(kind, scene, choice, arguments=arguments), ear)
    return ear


@pytest.mark.parametrize("name", ["lpv", "dom8"])
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_captured_states_come_back_bit_for_bit(name, precision):
    scene = scene_of()

    def run(steps):
        sim = Simulation(scene, propagators.create(name), bands=3, precision=precision)
        sim.inject()
        sim.run(steps)
        return sim

    simulation = run(7)
    snapshot = capture(simulation)
    simulation.run(20)
    restore(simulation, snapshot)
    assert_same_state(simulation, run(7))
    simulation.run(5)
    assert_same_state(simulation, run(12))


def test_history_brings_back_every_iteration_within_its_budget():
    scene = scene_of()
    simulation = Simulation(scene, propagators.create("lpv"), bands=2)
    simulation.inject()
    size = capture(simulation).nbytes
    history = History(budget=6 * size, spacing=2)
    states = {0: frame_of(simulation)}
    history.record(simulation)
    for i in range(1, 60):
        simulation.run(1)
        history.record(simulation)
        states[i] = frame_of(simulation)
        assert history.nbytes <= 6 * size
    assert history.spacing > 2
    for i in (59, 0, 17, 18, 3, 44, 59):
        history.go_to(simulation, i)
        for view, field in states[i].fields.items():
            np.testing.assert_array_equal(getattr(simulation, view).values, field.values)
        assert simulation.iteration == i


def test_engine_gives_the_numbers_of_the_command_line():
    scene = load_scene("fig5-one-light")
    choice = Choice("dom8", {"propagation_factor": 0.9}, bands=3)
    engine, ear = Engine(), Ear()
    perform(engine, "inject", choice, scene, ear)
    perform(engine, "step", choice, scene, ear, count=11)
    run = run_method(scene, choice.method(iterations=11))
    np.testing.assert_array_equal(ear.frames[-1].accumulated.values, run.accumulated.values)
    perform(engine, "solve", choice, scene, ear)
    solved = run_method(scene, choice.method(converge=1e-8))
    np.testing.assert_allclose(
        ear.frames[-1].accumulated.values, solved.accumulated.values, rtol=1e-12, atol=1e-15
    )


def test_a_cancelled_run_stops_within_one_iteration_and_keeps_its_state():
    scene, choice, engine = scene_of(), Choice(bands=2), Engine()
    perform(engine, "inject", choice, scene)
    ear = Ear(cancel_after=4)
    with pytest.raises(Cancelled):
        perform(engine, "run", choice, scene, ear)
    assert ear.frames[-1].iteration == 5
    again = perform(engine, "step", choice, scene)
    assert again.frames[-1].iteration == 6
    assert [row.iteration for row in ear.rows + again.rows] == [1, 2, 3, 4, 5, 6]


def test_a_cancelled_solve_leaves_the_run_where_it_was():
    scene, choice, engine = load_scene("shelf"), Choice(bands=2), Engine()
    ear = perform(engine, "inject", choice, scene)
    perform(engine, "step", choice, scene, ear, count=5)
    with pytest.raises(Cancelled):
        perform(engine, "solve", choice, scene, Ear(cancel_after=1))
    perform(engine, "step", choice, scene, ear)
    assert ear.frames[-1].iteration == 6
    run = run_method(scene, choice.method(iterations=6))
    np.testing.assert_array_equal(ear.frames[-1].accumulated.values, run.accumulated.values)


def test_an_unstable_run_is_told_and_stays():
    scene, choice, engine = (
        scene_of(shape=(24, 24)),
        Choice("dom4", {"emission": "delta"}, 4),
        Engine(),
    )
    ear = perform(engine, "inject", choice, scene)
    assert any("unstable" in text for text in ear.notices)
    perform(engine, "run", choice, scene, ear, count=4000)
    last = ear.frames[-1]
    assert last.unstable_at is not None
    assert np.all(np.isfinite(last.accumulated.values))
    perform(engine, "go_to", choice, scene, ear, iteration=3)
    assert ear.frames[-1].iteration == 3


def test_errors_are_those_of_the_studies():
    scene, choice, engine = load_scene("fig5-one-light"), Choice(bands=3), Engine()
    exact = Reference(scene).field(3)
    ear = perform(engine, "inject", choice, scene)
    perform(engine, "step", choice, scene, ear, count=6)
    perform(engine, "measure", choice, scene, ear, exact=exact)
    field = ear.frames[-1].accumulated
    found = errors_of(field, exact)
    assert found["mean_absolute"] == pytest.approx(metrics.infinity_mean_absolute(field, exact))
    assert found["mean_relative"] == pytest.approx(metrics.infinity_mean_relative(field, exact))
    assert found["coefficients"] == pytest.approx(metrics.relative_l2(field, exact))
    measured = {row.iteration: row for row in ear.rows if "coefficients" in row.values}
    assert sorted(measured) == list(range(7))
    assert measured[6].values["coefficients"] == pytest.approx(found["coefficients"])


def test_a_scheme_without_steps_answers_at_once():
    scene = load_scene("fig5-one-light")
    ear = perform(Engine(), "solve", Choice("analytic", bands=2), scene)
    exact = Reference(scene).field(2)
    np.testing.assert_allclose(ear.frames[-1].accumulated.values, exact.values, rtol=1e-12)


def test_choices_speak_the_words_of_the_command_line():
    choice = Choice("lpv", {"flux": "central", "clamp": True}, 3, blocking="fuzzy", bounces=False)
    words = choice.arguments()
    assert words == [
        "--propagator", "lpv", "--option", "flux=central", "--option", "clamp=true",
        "--bands", "3", "--blocking", "fuzzy", "--no-bounces",
    ]  # fmt: skip
    method = choice.method(iterations=4)
    assert method.propagator.values["clamp"] is True
    assert (method.blocking, method.bounces, method.iterations) == ("fuzzy", False, 4)
