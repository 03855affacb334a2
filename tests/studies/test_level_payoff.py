"""The cost of an error: trials and what is chosen of them."""

import pytest
from scenes import LPV, scene_of

from flatland.simulation import Simulation
from studies.level_payoff import (
    Trial,
    action_seconds,
    cheapest,
    coarse_trials,
    octree_trials,
    solve_trials,
    uniform_trials,
)
from studies.metrics import relative_l2

LIGHTS = [{"kind": "area", "start": [2.0, 1.0], "end": [6.0, 1.0], "flux": 6.0}]
SCENE = scene_of(LIGHTS, (8, 8))


@pytest.fixture(scope="module")
def measure():
    uniform = Simulation(SCENE, LPV)
    uniform.solve(1e-10)
    exact = uniform.accumulated
    return lambda field: relative_l2(field, exact)


def test_the_cheapest_trial_within_an_error():
    trials = [Trial("a", "", 0.5, 1.0), Trial("b", "", 0.2, 3.0), Trial("c", "", 0.1, 2.0)]
    assert cheapest(trials, 0.6).way == "a"
    assert cheapest(trials, 0.3).way == "c"
    assert cheapest(trials, 0.05) is None


def test_uniform_trials_are_runs_of_so_many_steps(measure):
    trials = uniform_trials(SCENE, LPV, 2, measure, steps=(2, 16))
    for trial, steps in zip(trials, (2, 16)):
        run = Simulation(SCENE, LPV)
        run.run(steps)
        assert trial.error == measure(run.accumulated)
        assert trial.seconds > 0
    assert trials[1].error < trials[0].error


def test_octree_trials_are_merges(measure):
    trials = octree_trials(SCENE, LPV, 2, measure, steps=(2, 4), patiences=(1.0, 2.0))
    assert len(trials) == 3 * 2 * 2 * 2
    run = Simulation(SCENE, LPV, levels=3, patience=2.0)
    run.run(4)
    found = {trial.setting: trial.error for trial in trials}
    assert found["3 levels, 4 steps, patience 2"] == measure(run.merge())
    assert found["3 levels, 4 steps, patience 2, blended"] == measure(run.merge(1.0))


def test_coarse_trials_spread_one_level(measure):
    trials = {trial.setting: trial for trial in coarse_trials(SCENE, LPV, 2, measure, steps=(3,))}
    assert set(trials) == {"level 1, 3 steps", "level 2, 3 steps", "level 3, 3 steps"}
    assert all(0 < trial.error < 2 for trial in trials.values())


def test_solve_trials_are_as_good_as_their_tolerance(measure):
    trials = solve_trials(SCENE, LPV, 2, measure, tolerances=(0.1, 1e-6))
    assert trials[1].error < 1e-4
    assert trials[0].error < 0.5


@pytest.mark.parametrize("levels", [1, 3])
def test_every_part_of_a_frame_is_timed_apart(levels):
    seconds = action_seconds(SCENE, LPV, 2, levels, 4, repeats=1)
    assert set(seconds) == {
        "inject_geometry", "inject", "downsample_geometry", "downsample", "propagate", "merge",
    }  # fmt: skip
    for name in ("downsample_geometry", "downsample", "merge"):
        assert (seconds[name] > 0) == (levels > 1)
    assert seconds["propagate"] > 0
