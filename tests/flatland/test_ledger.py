"""The flux ledger: emitted + created = left + absorbed + inside, and every entry by itself."""

import numpy as np
import pytest
from scenes import FLUX, LPV, SHAPE, after, lobe_scene, quiet, scene_of
from schemes import every_scheme
from stepping import plain_run

from flatland.injection import inject
from flatland.ledger import Ledger

#: Rounding of 50 steps, relative to the flux that was ever on the move.
ROUNDING = 1e-12
STEPS = 50
BANDS = {2: 4, 3: 2}
ENTRIES = ("emitted", "left", "absorbed", "inside", "created")

open_or_blocked = pytest.mark.parametrize("blocked", [False, True], ids=["open", "blocked"])


def run_both(propagator, dimension, blocked, rng):
    """The ledger of a run, and the same entries from plain steps [W]."""
    scene = scene_of() if dimension == 2 else lobe_scene((4, 3, 5), flux=FLUX)
    shape = scene.grid.shape
    simulation = quiet(propagator, scene, bands=BANDS[dimension])
    transmittance = None
    if blocked:
        transmittance = rng.uniform(size=(len(simulation.stencil.offsets), *shape))
        arguments = {"bands": BANDS[dimension], "transmittance": transmittance}
        simulation = quiet(propagator, scene, **arguments)
    simulation.run(STEPS)
    light = inject(scene, simulation.basis).values
    states, steps = plain_run(simulation.stencil, light, STEPS, transmittance)
    content = [state[0].sum() for state in states]
    expected = {
        "emitted": content[0],
        "left": sum(step.left for step in steps),
        "absorbed": sum(step.absorbed for step in steps),
        "inside": content[-1],
        "created": sum(step.sent - flux for step, flux in zip(steps, content)),
    }
    unit = simulation.basis.flux_weight
    moved = unit * sum(np.abs(state[0]).sum() for state in states)
    return simulation.ledger, {name: unit * entry for name, entry in expected.items()}, moved


@open_or_blocked
@every_scheme()
def test_books_close_and_every_entry_is_right(propagator, dimension, blocked, rng):
    ledger, expected, moved = run_both(propagator, dimension, blocked, rng)
    assert abs(ledger.closure) < ROUNDING * moved
    for name in ENTRIES:
        found = getattr(ledger, name)
        assert found == pytest.approx(expected[name], abs=ROUNDING * moved), name


def test_conserved_light_is_inside_or_has_left():
    for steps in (0, 1, 5, 50, 500):
        ledger = after(scene_of(), steps, LPV).ledger
        assert ledger.created == pytest.approx(0.0, abs=ROUNDING)
        assert ledger.left + ledger.inside == pytest.approx(FLUX, rel=ROUNDING)


def test_light_behind_closed_walls_is_absorbed():
    """Nothing passes anywhere: after one step all light has been stopped."""
    transmittance = np.zeros((4, *SHAPE))
    ledger = after(scene_of(), 1, LPV, transmittance=transmittance).ledger
    assert ledger.absorbed == pytest.approx(FLUX, rel=ROUNDING)
    assert ledger.inside == 0
    assert ledger.left == 0


def test_open_transmittance_is_no_transmittance():
    free = after(scene_of(), 20, LPV)
    one = after(scene_of(), 20, LPV, transmittance=np.ones((4, *SHAPE)))
    np.testing.assert_array_equal(one.accumulated.values, free.accumulated.values)
    assert one.ledger.absorbed == pytest.approx(0.0, abs=ROUNDING)


def test_entries_are_listed_by_name():
    ledger = after(scene_of(), 3, LPV).ledger
    assert set(ledger.as_dict()) == {*ENTRIES, "reflected", "medium", "dropped", "closure"}
    assert ledger.as_dict()["left"] == ledger.left


def test_mixed_books_are_sums():
    first = Ledger(*(np.asarray(float(i)) for i in (5, 1, 2, 3, 1)))
    second = Ledger(*(np.asarray(float(i)) for i in (8, 4, 2, 2, 0)))
    mixed = Ledger.mixed([first, second], np.array([[1.0, 0.0], [2.0, 0.5]]))
    np.testing.assert_array_equal(mixed.emitted, [5.0, 14.0])
    np.testing.assert_array_equal(mixed.left, [1.0, 4.0])
    np.testing.assert_array_equal(mixed.closure, [0.0, 0.0])
