"""Lights that move while everything else stays."""

import numpy as np
import pytest

import propagators
from flatland.errors import InputError
from flatland.scene import Scene
from flatland.simulation import Simulation

SHAPE = (20, 18)
WALLS = [
    {"kind": "polygon", "albedo": 0.6, "vertices": [[5.0, 6.0], [9.0, 7.0], [7.0, 12.0]]},
    {"kind": "segment", "albedo": 0.3, "start": [12.0, 3.0], "end": [16.0, 13.0]},
]


def scene_with(x, flux=2.0, walls=WALLS, **keys):
    light = {"kind": "point", "position": [x, 3.3], "flux": flux, **keys}
    return Scene.from_dict({"grid": {"shape": SHAPE}, "light": [light], "occluder": walls})


def simulation(scene, name="lpv", **arguments):
    return Simulation(scene, propagators.create(name), **arguments)


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
@pytest.mark.parametrize("name", ["lpv", "dom8"])
@pytest.mark.parametrize("method", ["auto", "mirrored"])
def test_a_moved_light_is_a_new_run(name, blocking, method):
    run = simulation(scene_with(3.2), name, blocking=blocking)
    run.solve(1e-9, method)
    run.relight(scene_with(14.1, flux=3e5))
    assert run.iteration == 0
    assert not run.accumulated.values.any()
    run.solve(1e-9, method)
    other = simulation(scene_with(14.1, flux=3e5), name, blocking=blocking)
    other.solve(1e-9, method)
    size = np.abs(other.accumulated.values).max()
    np.testing.assert_allclose(
        run.accumulated.values, other.accumulated.values, rtol=0, atol=1e-7 * size
    )
    assert run.ledger.emitted == pytest.approx(3e5, rel=1e-9)
    assert run.ledger.left == pytest.approx(other.ledger.left, rel=1e-6)


def test_steps_after_a_move_are_those_of_a_new_run():
    run = simulation(scene_with(3.2), levels=2)
    run.run(5)
    run.relight(scene_with(14.1))
    run.run(7)
    other = simulation(scene_with(14.1), levels=2)
    other.run(7)
    np.testing.assert_array_equal(run.accumulated.values, other.accumulated.values)
    np.testing.assert_array_equal(run.merge().values, other.merge().values)


def test_more_colours_of_light_than_before():
    run = simulation(scene_with(3.2, flux=(1.0, 2.0, 3.0)))
    run.solve()
    lights = [
        {"kind": "point", "position": [3.0, 3.0], "flux": [1.0, 0.0, 3.0]},
        {"kind": "point", "position": [14.0, 3.0], "flux": [0.0, 2.0, 1.0]},
    ]
    scene = Scene.from_dict({"grid": {"shape": SHAPE}, "light": lights, "occluder": WALLS})
    run.relight(scene)
    run.solve()
    other = simulation(scene)
    other.solve()
    assert len(run._states) == len(other._states) > 1
    np.testing.assert_allclose(run.accumulated.values, other.accumulated.values, atol=1e-7)


def test_what_is_dropped_stays_so_with_more_colours():
    run = simulation(scene_with(3.2, flux=(1.0, 2.0)), drop=1e-2)
    lights = [
        {"kind": "point", "position": [3.0, 3.0], "flux": [1.0, 0.0]},
        {"kind": "point", "position": [14.0, 3.0], "flux": [0.0, 2.0]},
    ]
    scene = Scene.from_dict({"grid": {"shape": SHAPE}, "light": lights, "occluder": WALLS})
    run.relight(scene)
    run.run(40)
    other = simulation(scene, drop=1e-2)
    other.run(40)
    assert (other.ledger.dropped > 0).all()
    np.testing.assert_array_equal(run.ledger.dropped, other.ledger.dropped)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (scene_with(3.2, walls=WALLS[:1]), "the same grid and occluders"),
        (scene_with(3.2, flux=(1.0, 2.0)), "as many colours"),
    ],
)
def test_nothing_but_lights_may_change(scene, message):
    with pytest.raises(InputError, match=message):
        simulation(scene_with(3.2)).relight(scene)


def test_lights_that_block_cannot_move():
    with pytest.raises(InputError, match="lights_block"):
        simulation(scene_with(3.2), lights_block=True).relight(scene_with(4.2))
