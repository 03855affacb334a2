"""When light gets where: distances in steps, and walls in the way."""

import numpy as np
import pytest
from scenes import after, scene_of
from schemes import stencil_classes
from stepping import neighbours, plain_run, random_stencil

from flatland.harmonics import basis_for
from flatland.octree.arrival import NEVER, arrival_steps


def _stencil(rng, dimension=2, diagonal=True):
    return random_stencil(rng, basis_for(dimension, 1), neighbours(dimension, diagonal))


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("shape", [(9, 6), (1, 7), (4, 5, 6)], ids=str)
def test_in_the_open_it_is_the_distance_in_steps(shape, diagonal, rng):
    cell = tuple(n // 3 for n in shape)
    lit = np.zeros(shape, bool)
    lit[cell] = True
    away = np.abs(np.indices(shape) - np.reshape(cell, (-1, *[1] * len(shape))))
    expected = away.max(axis=0) if diagonal else away.sum(axis=0)
    found = arrival_steps(lit, _stencil(rng, len(shape), diagonal))
    np.testing.assert_array_equal(found, expected)


def test_without_light_it_never_arrives(rng):
    assert np.all(arrival_steps(np.zeros((4, 5), bool), _stencil(rng)) == NEVER)


@pytest.mark.parametrize("free", [False, True])
def test_where_light_is_after_so_many_steps(free, rng):
    """Against light that is stepped, past links of which two thirds are shut."""
    stencil = _stencil(rng)
    shape = (12, 11)
    tau = (rng.random((8, *shape)) < 0.3).astype(float)
    values = np.zeros((1, *shape))
    values[0, 3, 4] = values[0, 8, 8] = 1.0
    arrival = arrival_steps(values[0] != 0, stencil, tau, free)
    states, _ = plain_run(stencil, values, 1, None if free else tau)
    states += plain_run(stencil, states[-1], 30, tau)[0][1:]
    reached = np.zeros(shape, bool)
    for step, state in enumerate(states):
        reached |= state[0] != 0
        np.testing.assert_array_equal(arrival <= step, reached)
    assert np.any(arrival == NEVER)


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
        arrival = arrival_steps(seeds, simulation.stencil)
        np.testing.assert_array_equal(arrival <= steps, lit)
