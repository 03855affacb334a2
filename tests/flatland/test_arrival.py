"""When light gets where: distances in steps, and walls in the way."""

import numpy as np
import pytest
from scenes import after, scene_of
from schemes import stencil_classes
from stepping import neighbours, plain_run, random_stencil

from flatland.harmonics import basis_for
from flatland.octree.arrival import NEVER, Arrival, offsets_used


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("shape", [(9, 6), (1, 7), (4, 5, 6)], ids=str)
def test_in_the_open_it_is_the_distance_in_steps(shape, diagonal):
    cell = tuple(n // 3 for n in shape)
    lit = np.zeros(shape, bool)
    lit[cell] = True
    away = np.abs(np.indices(shape) - np.reshape(cell, (-1, *[1] * len(shape))))
    expected = away.max(axis=0) if diagonal else away.sum(axis=0)
    arrival = Arrival(lit, neighbours(len(shape), diagonal))
    for steps in (2, 0, 3, 20):  # found as far as it is asked for, in any order
        np.testing.assert_array_equal(arrival.reached(steps), expected <= steps)
        assert arrival.complete(steps) == (expected.max() <= steps)
    np.testing.assert_array_equal(arrival.steps(), expected)


def test_without_light_it_never_arrives():
    arrival = Arrival(np.zeros((4, 5), bool), neighbours(2))
    assert np.all(arrival.steps() == NEVER)
    assert not arrival.complete(100)


@pytest.mark.parametrize("free", [False, True])
def test_where_light_is_after_so_many_steps(free, rng):
    """Against light that is stepped, past links of which two thirds are shut."""
    stencil = random_stencil(rng, basis_for(2, 1), neighbours(2))
    shape = (12, 11)
    tau = (rng.random((8, *shape)) < 0.3).astype(float)
    values = np.zeros((1, *shape))
    values[0, 3, 4] = values[0, 8, 8] = 1.0
    arrival = Arrival(values[0] != 0, stencil.offsets, tau, free)
    states, _ = plain_run(stencil, values, 1, None if free else tau)
    states += plain_run(stencil, states[-1], 30, tau)[0][1:]
    reached = np.zeros(shape, bool)
    for step, state in enumerate(states):
        reached |= state[0] != 0
        np.testing.assert_array_equal(arrival.reached(step), reached)
    assert np.any(arrival.steps() == NEVER)


SCHEMES = [(s(), d) for s in stencil_classes() for d in s.dimensions]


@pytest.mark.parametrize(("propagator", "dimension"), SCHEMES, ids=str)
def test_every_scheme_lights_what_it_is_said_to_reach(propagator, dimension):
    """The scheme's own light is not zero there, and zero elsewhere."""
    shape = (7, 6) if dimension == 2 else (5, 4, 4)
    cell = [3, 2, 1][:dimension]
    scene = scene_of([{"kind": "cell", "cell": cell, "flux": 1.0}], shape)
    for steps in (1, 2, 3):
        simulation = after(scene, steps, propagator, bands=2)
        lit = (simulation.accumulated.values != 0).any(axis=0)
        seeds = np.zeros(shape, bool)
        seeds[tuple(cell)] = True
        offsets = simulation.stencil.offsets[offsets_used(simulation.stencil)]
        arrival = Arrival(seeds, offsets)
        np.testing.assert_array_equal(arrival.reached(steps), lit)
