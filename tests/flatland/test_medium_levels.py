"""A medium on octree levels and cascades: collisions are per metre, whatever the cells."""

import numpy as np
import pytest
from scenes import LIGHTS, after

import propagators
from flatland.cascades import Cascade
from flatland.errors import InputError, SchemeWarning
from flatland.injectors.file import FileLight
from flatland.medium import Medium
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.snapshots import capture, restore

ROUNDING = 1e-12
WALL = {"kind": "segment", "start": [2.0, 5.3], "end": [7.0, 4.8], "albedo": 0.6}
schemes = pytest.mark.parametrize("name", ["dom4", "dom8", "lpv"])
quiet = pytest.mark.filterwarnings("ignore::flatland.errors.SchemeWarning")


def filled(extinction=0.3, albedo=0.8, walls=(), lights=LIGHTS, shape=(8, 8)):
    return Scene.from_dict(
        {
            "grid": {"shape": shape},
            "light": lights,
            "occluder": list(walls),
            "medium": {"extinction": extinction, "albedo": albedo},
        }
    )


@schemes
@quiet
def test_a_level_is_a_run_on_its_own_grid(name):
    """Cells of side 2^i h meet 2^i times as much of the medium in a step."""
    propagator = propagators.create(name)
    octree = after(filled(), 0, propagator, bands=3, levels=3)
    starts = [octree.level(number).accumulated.values for number in range(3)]
    octree.run(9)
    for number in (1, 2):
        grid = octree.level(number).grid
        tables = {
            "grid": {"shape": grid.shape, "spacing": grid.spacing},
            "medium": {"extinction": 0.3, "albedo": 0.8},
        }
        light = FileLight.of_values(starts[number])
        alone = Scene.from_dict(tables).model_copy(update={"lights": (light,)})
        twin = after(alone, 9, propagator, bands=3)
        expected = twin.accumulated.values
        np.testing.assert_allclose(
            octree.level(number).accumulated.values, expected, rtol=0, atol=1e-13
        )
        assert octree.level(number).ledger.medium == pytest.approx(twin.ledger.medium, rel=1e-12)


@schemes
@quiet
@pytest.mark.parametrize("walls", [(), (WALL,)], ids=["open", "wall"])
def test_books_close_on_every_level(name, walls):
    octree = after(filled(walls=walls), 7, propagators.create(name), bands=2, levels=3)
    for number in range(3):
        ledger = octree.level(number).ledger
        assert abs(ledger.closure) < ROUNDING
        assert ledger.medium > 0.1
        assert (ledger.absorbed > 1e-3) == bool(walls)
    octree.solve(1e-12)
    for number in range(3):
        assert abs(octree.level(number).ledger.closure) < 1e-10
        assert octree.level(number).ledger.medium > 0.1


@quiet
def test_light_that_came_down_in_mid_flight_is_booked_once():
    """What has accumulated above is no light that this level sent."""
    octree = Simulation(filled(albedo=0.4), propagators.create("dom8"), bands=2, levels=2)
    octree.inject()
    octree.downsample_geometry()
    octree.run(4)
    octree.downsample()
    before = octree.level(1).ledger
    assert before.medium == pytest.approx(0, abs=ROUNDING)
    octree.run(40)
    after_all = octree.level(1).ledger
    assert abs(after_all.closure) < ROUNDING
    assert 0 < after_all.medium < after_all.emitted
    assert after_all.absorbed == pytest.approx(0, abs=ROUNDING)


@quiet
def test_a_run_comes_back_with_its_books():
    octree = Simulation(filled(walls=[WALL]), propagators.create("dom8"), bands=2, levels=2)
    octree.inject()
    octree.downsample_geometry()
    octree.run(3)
    early = capture(octree)
    octree.downsample()
    octree.run(2)
    late, books = capture(octree), octree.level(1).ledger.as_dict()
    restore(octree, early)
    assert octree.level(1).ledger.medium == 0
    restore(octree, late)
    assert octree.level(1).ledger.as_dict() == books


@quiet
def test_no_extinction_is_a_vacuum_bit_for_bit_on_levels():
    plain = Scene.from_dict({"grid": {"shape": (8, 8)}, "light": LIGHTS, "occluder": [WALL]})
    runs = [
        after(scene, 6, propagators.create("dom8"), bands=2, levels=3)
        for scene in (plain, filled(0.0, 0.7, [WALL]))
    ]
    np.testing.assert_array_equal(runs[0].merge().values, runs[1].merge().values)


@quiet
def test_merged_light_fades_as_on_the_uniform_grid():
    """A coarse level would let light through for 2^i cells' worth of free flight otherwise."""
    light = {"kind": "cell", "cell": [16, 16], "flux": 1.0}
    scene = filled(0.15, 0.5, lights=[light], shape=(33, 33))
    propagator = propagators.create("dom8")
    truth = after(scene, 80, propagator, bands=2).accumulated.scalar_flux()
    octree = after(scene, 10, propagator, bands=2, levels=4)
    merged = octree.merge().scalar_flux()
    vacuum = after(filled(0.0, 0.5, lights=[light], shape=(33, 33)), 10, propagator, bands=2,
                   levels=4).merge().scalar_flux()  # fmt: skip
    far = np.hypot(*(np.indices((33, 33)) - 16.0)) > 8
    ratio = merged[far].sum() / truth[far].sum()
    assert 0.5 < ratio < 2
    assert vacuum[far].sum() > 3 * truth[far].sum()


def test_levels_are_warned_of_together():
    rule = r"37.5% of it at 0.5 collisions a cell \(level 0\), 58.6% of it at 1 .* \(level 1\)$"
    with pytest.warns(SchemeWarning, match=rule):
        Simulation(filled(0.5), propagators.create("lpv"), bands=2, levels=2)


def test_levels_that_nothing_passes_are_refused():
    with pytest.raises(InputError, match=r"extinction = 200.0: leaves e\^-1131 of the light"):
        Simulation(filled(200.0), propagators.create("dom8"), levels=3)


@quiet
def test_cascades_know_the_medium_too():
    """All grids hold the lights; a coarse one is a run of its own, through the same metres."""
    scene = filled(shape=(16, 16))
    cascade = Cascade(scene, propagators.create("dom8"), bands=2, levels=2, cells=8, focus=(4, 4))
    cascade.run(6)
    for level, step in enumerate(each.medium for each in cascade._levels):
        ledger = cascade.ledger(level)
        assert abs(ledger.closure) < ROUNDING
        assert ledger.medium > 0.1
        assert step.medium == Medium(0.3, 0.8)
        assert step.optical == pytest.approx(0.3 * 2**level)
