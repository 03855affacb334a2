"""Small scenes, and runs of them."""

import warnings

import numpy as np

import propagators
from flatland.errors import SchemeWarning
from flatland.scene import Scene
from flatland.simulation import Simulation

#: Light that no symmetry makes simple: a lobe, an isotropic cell, a wall and a slanted segment.
LIGHTS = [
    {"kind": "cell", "cell": [2, 3], "direction": [1.0, 0.4], "flux": 2.0},
    {"kind": "cell", "cell": [5, 1], "flux": 1.0},
    {"kind": "wall", "side": "left", "flux": 3.0, "first": 1, "last": 4},
    {"kind": "area", "start": [3.1, 4.0], "end": [5.7, 4.9], "flux": 1.5},
]
SHAPE = (8, 7)
#: Flux of all lights together.
FLUX = 7.5
LPV = propagators.create("lpv")


def scene_of(lights=LIGHTS, shape=SHAPE):
    return Scene.from_dict({"grid": {"shape": shape}, "light": lights})


def coloured(*spectra):
    """The first lights, one for each spectrum given."""
    return [dict(light, flux=spectrum) for light, spectrum in zip(LIGHTS, spectra)]


def lobe_scene(shape, flux=1.0):
    """One Lambertian cell in the middle of a grid, along the first axis."""
    direction = [1.0, *[0.0] * (len(shape) - 1)]
    cell = [n // 2 for n in shape]
    return scene_of([{"kind": "cell", "cell": cell, "direction": direction, "flux": flux}], shape)


def quiet(propagator, scene, **arguments):
    """A simulation of a scheme that may be unstable on purpose."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SchemeWarning)
        return Simulation(scene, propagator, **arguments)


def after(scene, steps, propagator=LPV, **arguments):
    """A simulation that has done some steps."""
    simulation = quiet(propagator, scene, **arguments)
    simulation.run(steps)
    return simulation


def assert_same_state(first, second):
    """Bit for bit the same light, and the same books."""
    assert first.iteration == second.iteration
    for name in ("source", "target", "accumulated"):
        np.testing.assert_array_equal(getattr(first, name).values, getattr(second, name).values)
    for name in ("emitted", "left", "absorbed", "inside", "created"):
        # Sums of the same numbers, batch by batch.
        entries = (getattr(simulation.ledger, name) for simulation in (first, second))
        np.testing.assert_allclose(*entries, rtol=1e-13, atol=1e-15)
