"""Actions in any order: what is skipped cannot be seen, and level 0 does not notice the others."""

import warnings

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scenes import LPV, scene_of

from flatland.errors import SchemeWarning
from flatland.scene import Scene
from flatland.simulation import Simulation

WALLS = [{"kind": "segment", "start": [4.0, 0.0], "end": [4.3, 5.0], "albedo": 0.4}]
SCENE = Scene.from_dict({**scene_of().to_dict(), "occluder": WALLS})
LEVELS = 4
ACTIONS = ("reset", "inject", "downsample", "downsample_geometry", "start", "step", "run", "solve")


@st.composite
def rules(draw):
    return {
        "blocking": draw(st.sampled_from(["exact", "fuzzy"])),
        "index": draw(st.sampled_from(["finest", "symmetric"])),
        "patience": draw(st.sampled_from([1.0, 2.0])),
    }


HASTY = {"blocking": "fuzzy", "index": "finest", "patience": 1.0}


def act(simulation, action):
    """One action; of a uniform simulation those of an octree are nothing."""
    if action == "run":
        simulation.run(3)
    elif action == "solve":
        simulation.solve(1e-10)
    else:
        getattr(simulation, action)()


@settings(max_examples=20)
@example(["inject", "downsample", "run", "run", "downsample_geometry", "run"], HASTY)
@example(["inject", "run", "downsample", "run", "downsample_geometry", "downsample", "step"], HASTY)
@example(["solve", "downsample", "downsample_geometry", "run"], HASTY)
@given(st.lists(st.sampled_from(ACTIONS), min_size=1, max_size=8), rules())
def test_skipping_run_full_run_and_uniform_run_agree(actions, rules):
    runs = [
        Simulation(SCENE, LPV, bands=1, levels=levels, skip=skip, **rules)
        for levels, skip in ((LEVELS, True), (LEVELS, False), (1, True))
    ]
    skipping, full, uniform = runs
    for action in actions:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SchemeWarning)
            for run in runs:
                act(run, action)
        np.testing.assert_array_equal(skipping.index, full.index)
        np.testing.assert_array_equal(skipping.merge().values, full.merge().values)
    for name in ("source", "target", "accumulated"):
        for number in range(LEVELS):
            fields = [getattr(run.level(number), name).values for run in (skipping, full)]
            np.testing.assert_array_equal(*fields)
        found, expected = (getattr(run, name).values for run in (full, uniform))
        np.testing.assert_array_equal(found, expected)
    assert skipping.iteration == full.iteration == uniform.iteration
    for number in range(LEVELS):
        ledger = skipping.level(number).ledger
        assert abs(ledger.closure) < 1e-9
