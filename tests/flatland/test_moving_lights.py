"""Many lights among the same walls."""

from collections import OrderedDict

import numpy as np
import pytest

import propagators
from flatland import InputError, Scene, Simulation, converged_fields
from flatland.solvers import methods

WALL = {"kind": "segment", "start": [10.0, 4.0], "end": [22.0, 20.0], "albedo": 0.5}


def room(cell, flux=2.0, walls=(WALL,)):
    light = {"kind": "cell", "cell": list(cell), "flux": flux}
    grid = {"shape": [64, 64]}
    return Scene.from_dict({"grid": grid, "light": [light], "occluder": list(walls)})


PLACES = [(3, 5), (40, 8), (12, 50)]


@pytest.mark.parametrize("name", ["lpv", "dom8"])
def test_each_is_what_a_simulation_of_its_own_finds(name, monkeypatch):
    monkeypatch.setattr(methods, "_reduced", OrderedDict())
    scheme = propagators.create(name)
    scenes = [room(place) for place in PLACES]
    fields = list(converged_fields(Simulation(scenes[0], scheme), scenes, 1e-9))
    assert len(methods._reduced) == 1  # set up once
    for scene, field in zip(scenes, fields):
        alone = Simulation(scene, scheme)
        alone.solve(1e-9, "krylov")
        expected = alone.accumulated.values
        np.testing.assert_allclose(field.values, expected, atol=1e-7 * np.abs(expected).max())


def test_light_adds_up():
    """The field of two lamps is the sum of theirs."""
    both = Scene.from_dict(
        {**room((3, 5)).to_dict(), "light": [*_lights((3, 5)), *_lights((40, 8))]}
    )
    scenes = [room((3, 5)), room((40, 8)), both]
    first, second, together = converged_fields(
        Simulation(scenes[0], propagators.create("lpv")), scenes, 1e-10
    )
    size = np.abs(together.values).max()
    np.testing.assert_allclose(
        first.values + second.values, together.values, rtol=0, atol=1e-8 * size
    )


def _lights(cell):
    return room(cell).to_dict()["light"]


def test_other_walls_are_refused():
    simulation = Simulation(room((3, 5)), propagators.create("lpv"))
    with pytest.raises(InputError, match="same grid and occluders"):
        next(converged_fields(simulation, [room((3, 5), walls=())]))
