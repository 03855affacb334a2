"""The octree's actions: alone, in any order, and what they keep."""

import numpy as np
import pytest
from scenes import LPV, SHAPE, after, assert_same_state, coloured, quiet, scene_of

import flatland.memory
import propagators
from flatland.errors import InputError, InstabilityError, SchemeWarning
from flatland.octree import halved
from flatland.patch import Patch
from flatland.scene import Scene
from flatland.simulation import Simulation

#: Rounding of some dozen steps.
ROUNDING = 1e-12
LEVELS = 4
WALLS = [{"kind": "segment", "start": [4.0, 0.0], "end": [4.3, 5.0], "albedo": 0.4}]


def walled(**changes):
    return Scene.from_dict({**scene_of(**changes).to_dict(), "occluder": WALLS})


def octree(scene=None, steps=None, **options):
    simulation = quiet(options.pop("propagator", LPV), scene or scene_of(), levels=4, **options)
    if steps is not None:
        simulation.run(steps)
    return simulation


def level_values(simulation, number, name="accumulated"):
    return getattr(simulation.level(number), name).values


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("blocking", ["exact", "fuzzy", "none"])
def test_level_0_is_the_uniform_engine_bit_for_bit(blocking, precision):
    options = {"blocking": blocking, "precision": precision, "bands": 3}
    assert_same_state(after(walled(), 9, levels=LEVELS, **options), after(walled(), 9, **options))


def test_one_level_merges_to_itself_bit_for_bit():
    simulation = after(walled(), 9)
    np.testing.assert_array_equal(simulation.merge().values, simulation.accumulated.values)
    newest = simulation.merge(name="target").values
    np.testing.assert_array_equal(newest, simulation.target.values)
    assert not simulation.index.any()


def test_every_level_is_a_simulation_of_its_own():
    """Injected with the mean, stepped on its own grid with its own walls."""
    simulation = octree(walled(), 7, normalization="mean")
    for number in range(1, LEVELS):
        view = simulation.level(number)
        occlusion = simulation.octree.levels[number].occlusion
        start = octree(walled(), 0, normalization="mean").level(number).target.values
        alone = _level_alone(view.grid, occlusion, start)
        alone.run(7)
        np.testing.assert_array_equal(view.accumulated.values, alone.accumulated.values)
        assert view.ledger.left == pytest.approx(float(alone.ledger.left), rel=1e-13)


def _level_alone(grid, occlusion, start):
    """A uniform simulation of a level's grid; reflecting walls are the level's own."""
    light = {"kind": "cell", "cell": [0, 0], "flux": 1.0}
    scene = Scene.from_dict({"grid": grid, "light": [light]})
    simulation = Simulation(scene, LPV)
    level = simulation.octree.levels[0]
    level.block(occlusion)
    scale = simulation._states[0].scale
    simulation.inject()
    level.start([Patch.everywhere(start / scale)])
    return simulation


class TestDownsampling:
    @pytest.mark.parametrize("scene", [scene_of(), scene_of(shape=(6, 9))], ids=["8x7", "6x9"])
    @pytest.mark.parametrize(
        ("options", "factors"),
        [
            ({"normalization": "mean"}, [1, 1, 1, 1]),
            ({"normalization": "flux"}, [1, 2, 4, 8]),
            ({"level_factors": [1, 2.5, 6, 0.5]}, [1, 2.5, 6, 0.5]),
        ],
        ids=["mean", "flux", "given"],
    )
    def test_every_level_is_injected_with_its_factor_times_the_mean(self, scene, options, factors):
        simulation = octree(scene, 0, **options)
        mean = level_values(simulation, 0, "target")
        for number in range(1, LEVELS):
            mean = halved(mean, 2)
            found = level_values(simulation, number, "target")
            np.testing.assert_allclose(found, factors[number] * mean, rtol=1e-14, atol=1e-18)
            ledger = simulation.level(number).ledger
            expected = factors[number] / 4**number * simulation.ledger.emitted
            assert ledger.emitted == pytest.approx(float(expected), rel=1e-13)

    def test_injection_alone_leaves_coarse_levels_dark(self):
        simulation = octree()
        simulation.inject()
        simulation.run(3)
        for number in range(1, LEVELS):
            assert not level_values(simulation, number).any()
            assert simulation.level(number).ledger.emitted == 0

    def test_later_downsampling_takes_over_what_has_passed(self):
        """Light in flight is emitted anew, with the factor; what has passed compares as it is."""
        simulation = octree()
        simulation.inject()
        simulation.run(4)
        simulation.downsample()
        newest, total = simulation.target.values, simulation.accumulated.values
        for number in range(1, LEVELS):
            newest, total = halved(newest, 2), halved(total, 2)
            factor = 2.0**number
            found = level_values(simulation, number)
            np.testing.assert_allclose(found, total + (factor - 1) * newest, atol=1e-14)
            np.testing.assert_allclose(
                level_values(simulation, number, "target"), factor * newest, atol=1e-15
            )

    def test_downsampled_late_it_runs_on_from_there(self):
        """Three steps, downsampled, four more: level 1 has done four steps."""
        simulation = octree(normalization="mean")
        simulation.inject()
        simulation.run(3)
        simulation.downsample()
        start = level_values(simulation, 1, "target").copy()
        simulation.run(4)
        twin = _level_alone(simulation.level(1).grid, simulation.octree.levels[1].occlusion, start)
        twin.run(4)
        np.testing.assert_array_equal(level_values(simulation, 1, "target"), twin.target.values)
        assert simulation.iteration == 7

    def test_downsampling_a_converged_field_gives_its_means(self):
        simulation = octree()
        simulation.solve(1e-10)
        simulation.downsample()
        mean = simulation.accumulated.values
        for number in range(1, LEVELS):
            mean = halved(mean, 2)
            np.testing.assert_allclose(level_values(simulation, number), mean, atol=1e-15)

    def test_repeating_it_changes_nothing(self):
        once, twice = octree(steps=0), octree(steps=0)
        twice.downsample()
        for number in range(LEVELS):
            np.testing.assert_array_equal(level_values(once, number), level_values(twice, number))


class TestActions:
    def test_a_run_fills_all_levels_itself(self):
        by_hand = octree(walled())
        by_hand.inject()
        by_hand.downsample()
        by_hand.downsample_geometry()
        by_hand.run(5)
        by_itself = octree(walled(), 5)
        for number in range(LEVELS):
            np.testing.assert_array_equal(
                level_values(by_hand, number), level_values(by_itself, number)
            )

    def test_reset_takes_all_light_away(self):
        simulation = octree(steps=5)
        simulation.merge()
        simulation.reset()
        assert simulation.iteration == 0
        assert simulation.merged is None
        for number in range(LEVELS):
            assert not level_values(simulation, number).any()

    def test_order_of_light_and_geometry_does_not_matter(self):
        first, second = octree(walled()), octree(walled())
        for simulation, actions in (
            (first, ("downsample_geometry", "inject", "downsample")),
            (second, ("inject", "downsample", "downsample_geometry")),
        ):
            for action in actions:
                getattr(simulation, action)()
            simulation.run(6)
        for number in range(LEVELS):
            np.testing.assert_array_equal(level_values(first, number), level_values(second, number))

    def test_geometry_that_was_not_downsampled_blocks_nothing_and_says_so_once(self, recwarn):
        simulation = Simulation(walled(), LPV, levels=2)
        simulation.inject()
        simulation.downsample()
        simulation.run(3)
        simulation.run(3)
        warnings = [entry for entry in recwarn if entry.category is SchemeWarning]
        assert len(warnings) == 1
        assert "block nothing on coarse levels" in str(warnings[0].message)
        free = octree(steps=6)
        np.testing.assert_array_equal(level_values(simulation, 1), level_values(free, 1))

    def test_a_run_from_the_start_fills_in_the_geometry_that_was_missing(self):
        simulation = octree(walled())
        simulation.inject()
        simulation.downsample()
        with pytest.warns(SchemeWarning, match="block nothing on coarse levels"):
            simulation.run(2)
        simulation.reset()
        simulation.run(5)
        np.testing.assert_array_equal(
            level_values(simulation, 1), level_values(octree(walled(), 5), 1)
        )

    def test_geometry_may_come_in_the_middle_of_a_run(self):
        simulation = octree(walled())
        simulation.inject()
        simulation.downsample()
        with pytest.warns(SchemeWarning, match="block nothing on coarse levels"):
            simulation.run(2)
        before = level_values(simulation, 1, "target").copy()
        simulation.downsample_geometry()
        np.testing.assert_array_equal(level_values(simulation, 1, "target"), before)
        simulation.run(1)
        twin = _level_alone(simulation.level(1).grid, simulation.octree.levels[1].occlusion, before)
        twin.run(1)
        np.testing.assert_allclose(
            level_values(simulation, 1, "target"), twin.target.values, atol=1e-16
        )

    def test_without_walls_nothing_is_said(self):
        simulation = octree()
        simulation.inject()
        simulation.downsample()
        simulation.run(3)  # warnings are errors here


class TestSkipping:
    """Levels that no merge can read are left behind, and nobody can tell."""

    @pytest.mark.parametrize(
        ("index", "patience"), [("finest", 1), ("finest", 2), ("symmetric", 1)]
    )
    @pytest.mark.parametrize("pieces", [[9], [1] * 9, [0, 4, 5]], ids=str)
    def test_full_and_skipping_run_agree_bit_for_bit(self, pieces, index, patience):
        scene = walled(shape=(16, 16))
        rules = {"levels": 5, "index": index, "patience": patience}
        runs = [Simulation(scene, LPV, **rules, skip=skip) for skip in (True, False)]
        for simulation in runs:
            for piece in pieces:
                simulation.run(piece)
        skipping, full = runs
        np.testing.assert_array_equal(skipping.index, full.index)
        for blend in (None, 1.5):
            np.testing.assert_array_equal(skipping.merge(blend).values, full.merge(blend).values)
        for number in range(5):
            np.testing.assert_array_equal(
                level_values(skipping, number), level_values(full, number)
            )

    def test_levels_without_a_reader_do_not_move(self):
        simulation = Simulation(scene_of(shape=(16, 16)), LPV, levels=5)
        simulation.run(12)
        simulation.merge()
        read = set(np.unique(simulation.index))
        assert len(read) < 5
        for number, level in enumerate(simulation.octree.levels):
            assert level.iteration == (12 if number in read else 0)

    @pytest.mark.parametrize("skip", [True, False])
    def test_solved_levels_are_the_same(self, skip):
        simulation = octree(walled(), skip=skip)
        simulation.solve(1e-11)
        assert not simulation.index.any()
        np.testing.assert_array_equal(simulation.merge().values, simulation.accumulated.values)
        stepped = octree(walled(), 400)
        for number in range(LEVELS):
            np.testing.assert_allclose(
                level_values(simulation, number), level_values(stepped, number), atol=1e-8
            )


class TestColours:
    def test_levels_are_mixed_like_level_0(self):
        """One index volume serves all colours, so each of them has some of every light here."""
        spectra = [1.0, 2.0, 0.5], [0.5, 1.0, 4.0]
        simulation = octree(scene_of(coloured(*spectra)), 6)
        for colour, fluxes in enumerate(zip(*spectra)):
            mono = octree(scene_of(coloured(*fluxes)), 6)
            for number in range(LEVELS):
                np.testing.assert_allclose(
                    level_values(simulation, number)[colour],
                    level_values(mono, number),
                    atol=ROUNDING,
                )
            np.testing.assert_allclose(
                simulation.merge().values[colour], mono.merge().values, atol=ROUNDING
            )
            assert simulation.level(2).ledger.left[colour] == pytest.approx(
                float(mono.level(2).ledger.left), abs=ROUNDING
            )

    def test_coloured_walls_step_every_colour_on_every_level(self):
        wall = [dict(WALLS[0], albedo=[0.1, 0.5, 0.9])]
        scene = Scene.from_dict({**scene_of().to_dict(), "occluder": wall})
        simulation = octree(scene, 5)
        grey = Scene.from_dict({**scene_of().to_dict(), "occluder": [dict(WALLS[0], albedo=0.5)]})
        np.testing.assert_allclose(
            simulation.merge().values[1], octree(grey, 5).merge().values, atol=ROUNDING
        )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"normalization": "sum"}, "normalization = 'sum': is unknown; accepted: flux, mean"),
        ({"index": "coarsest"}, "index = 'coarsest': is unknown; accepted: finest, symmetric"),
        ({"falloff": "miles"}, "falloff = 'miles': is unknown; accepted: cells, metres"),
        ({"patience": 0.5}, "patience = 0.5: must be finite and at least 1"),
        ({"patience": np.nan}, "patience = nan: must be finite and at least 1"),
        ({"level_factors": [1, 2]}, "must be 3 positive numbers, one per level, the first"),
        ({"level_factors": [2, 2, 2]}, "level_factors = [2, 2, 2]: must be 3 positive numbers"),
        ({"level_factors": [1, 0, 2]}, "level_factors = [1, 0, 2]: must be 3 positive numbers"),
        ({"level_factors": [1, np.nan, 2]}, "must be 3 positive numbers"),
        ({"level_factors": "flux"}, "level_factors = 'flux': must be 3 positive numbers"),
        ({"transmittance": np.ones((4, *SHAPE))}, "cannot be given for more than one level"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(InputError) as caught:
        Simulation(scene_of(), LPV, levels=3, **arguments)
    assert message in str(caught.value)


@pytest.mark.parametrize("number", [-1, 4, 1.0, True, None], ids=repr)
def test_levels_that_are_not_there_are_refused(number):
    with pytest.raises(InputError, match=r"level = .*: must be a whole number, 0 to 3"):
        octree().level(number)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "total"}, "name = 'total': is unknown; accepted: source, target, accumulated"),
        ({"blend": -1.0}, "blend = -1.0: must be finite and at least 0"),
        ({"blend": np.inf}, "blend = inf: must be finite and at least 0"),
    ],
)
def test_merges_that_cannot_be_are_refused(arguments, message):
    with pytest.raises(InputError) as caught:
        octree(steps=1).merge(**arguments)
    assert message in str(caught.value)


def test_levels_count_in_the_memory_that_is_asked_for(monkeypatch):
    scene = scene_of(shape=(1000, 1000), lights=[])
    found = []
    for levels in (1, 2, 11):
        monkeypatch.setattr(flatland.memory, "available_memory", lambda: 2**20)
        with pytest.raises(InputError) as caught:
            Simulation(scene, propagators.create("lpv"), levels=levels)
        found.append(float(str(caught.value).partition("needs ")[2].partition(" GiB")[0]))
    # 3 fields a level of a quarter of the cells each, and the pattern on level 0.
    assert found[1] / found[0] == pytest.approx((3 * 1.25 + 1) / 4, rel=0.1)
    assert found[2] / found[0] == pytest.approx((3 * 4 / 3 + 1) / 4, rel=0.1)


def test_levels_whose_light_grows_wild_stop_and_can_be_looked_at():
    scheme = propagators.create("dom4", emission="delta")
    scene = scene_of([{"kind": "cell", "cell": [16, 16], "flux": 1.0}], (33, 33))
    simulation = quiet(scheme, scene, bands=3, levels=3, skip=False)
    with pytest.raises(InstabilityError, match="grown by a factor"):
        simulation.run(3000)
    assert 0 < simulation.iteration < 3000
    for number in range(3):
        assert np.all(np.isfinite(level_values(simulation, number)))
    assert np.all(np.isfinite(simulation.merge().values))
    with pytest.raises(InstabilityError):
        simulation.step()
