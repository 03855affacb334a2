"""What is its own mirror image is stepped by halves, and nobody can tell."""

import numpy as np
import pytest
from images import images_of, lights, scene_of, walls
from schemes import every_scheme

import propagators
from flatland import Scene, Simulation, load_scene, mirror_axes
from flatland.cascades import Cascade
from flatland.snapshots import capture, restore

LPV = propagators.create("lpv")
#: Even and odd; rows that are fewer vectors when they are halved, in both precisions.
SHAPES = {2: [(14, 36), (13, 37)], 3: [(8, 10, 20), (7, 9, 37)]}
ROUNDING = {"float64": 1e-13, "float32": 5e-6}


@pytest.fixture
def any_size(monkeypatch):
    """Grids are folded however small they are."""
    for name in ("WORTH_FOLDING", "WORTH_FOLDING_ALONE"):
        monkeypatch.setattr(mirror_axes, name, 0)
    monkeypatch.setattr(mirror_axes, "FEWEST_CELLS", 3)


def folded(simulation, level=0):
    return simulation.octree.levels[level].light.fold.axes


def both(scene, propagator=LPV, **options):
    return [Simulation(scene, propagator, skip=skip, **options) for skip in (True, False)]


def assert_agree(half, whole, names=("source", "target", "accumulated")):
    """All fields of all levels, and the books, to rounding."""
    rounding = ROUNDING[half.precision]
    for number in range(half.levels):
        mine, all_ = half.level(number), whole.level(number)
        size = np.abs(all_.accumulated.values).max()
        for name in names:
            found, expected = (getattr(view, name).values for view in (mine, all_))
            np.testing.assert_allclose(found, expected, rtol=0, atol=rounding * size)
        flux = float(np.max(whole.ledger.emitted))
        for name, value in all_.ledger.as_dict().items():
            found = mine.ledger.as_dict()[name]
            np.testing.assert_allclose(found, value, rtol=0, atol=20 * rounding * flux)
    np.testing.assert_array_equal(half.index, whole.index)


def assert_folding_changes_nothing(scene, axes, propagator=LPV, pieces=(1, 2, 21), **options):
    half, whole = both(scene, propagator, **options)
    for piece in pieces:
        for simulation in (half, whole):
            simulation.run(piece)
        assert_agree(half, whole)
    assert folded(half) == axes
    assert folded(whole) == ()
    return half


@every_scheme()
@pytest.mark.parametrize("odd", [False, True])
def test_every_scheme_in_the_open(propagator, dimension, odd, any_size):
    shape = SHAPES[dimension][odd]
    axes = tuple(range(dimension))
    scene = scene_of(shape, axes, with_walls=False)
    assert_folding_changes_nothing(scene, axes, propagator)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize(
    ("blocking", "bounces"), [("exact", False), ("exact", True), ("fuzzy", False), ("fuzzy", True)]
)
@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize(
    ("name", "dimension"), [("lpv", 2), ("dom8", 2), ("lpv", 3), ("dom26", 3)], ids=str
)
def test_walls_and_what_they_send_back(
    name, dimension, odd, blocking, bounces, precision, any_size
):
    axes = tuple(range(dimension))
    half = assert_folding_changes_nothing(
        scene_of(SHAPES[dimension][odd], axes),
        axes,
        propagators.create(name),
        blocking=blocking,
        bounces=bounces,
        precision=precision,
    )
    assert bool(half.ledger.reflected > 0) == bounces
    assert half.ledger.absorbed > 0


@pytest.mark.parametrize("axes", [(), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2)])
def test_only_along_axes_of_the_scene(axes, any_size):
    assert_folding_changes_nothing(scene_of((8, 10, 20), axes), axes)


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
def test_clamped_schemes(clamp, blocking, any_size):
    scheme = propagators.create("lpv", clamp=clamp)
    light = lights((5, 13), (13, 36), (0, 1), direction=np.array([0.6, 0.8]))
    scene = scene_of((13, 36), (0, 1), light)
    half = assert_folding_changes_nothing(scene, (0, 1), scheme, blocking=blocking)
    assert bool(half.ledger.created > 1e-6) == clamp


@pytest.mark.filterwarnings("ignore:in this medium")
@pytest.mark.parametrize("blocking", ["exact", "none"])
@pytest.mark.parametrize("shape", [(14, 36), (13, 37), (8, 9, 20)], ids=str)
def test_a_medium(shape, blocking, any_size):
    axes = tuple(range(len(shape)))
    scene = scene_of(shape, axes, medium={"extinction": 0.3, "albedo": 0.7})
    half = assert_folding_changes_nothing(scene, axes, blocking=blocking)
    assert half.ledger.medium > 0.1


@pytest.mark.parametrize("levels", [2, 3])
@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
@pytest.mark.parametrize("shape", [(16, 64), (8, 16, 40)], ids=str)
def test_levels_are_halved_and_merged_as_wholes(shape, blocking, levels, any_size):
    axes = tuple(range(len(shape)))
    half = assert_folding_changes_nothing(
        scene_of(shape, axes), axes, levels=levels, blocking=blocking, pieces=(2, 9)
    )
    assert folded(half, 1)[:-1] == axes[:-1]  # rows of coarse levels may be too short
    whole = Simulation(scene_of(shape, axes), LPV, levels=levels, blocking=blocking, skip=False)
    whole.run(11)
    for blend in (None, 2.0):
        found, expected = half.merge(blend).values, whole.merge(blend).values
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_an_odd_grid_halves_its_own_level_alone(any_size):
    """The last cell of a coarse level is covered by half: that is no mirror image of the first."""
    half = assert_folding_changes_nothing(scene_of((13, 37), (0, 1)), (0, 1), levels=2)
    assert folded(half, 1) == ()


def test_light_that_leaves_the_mirror_and_comes_back(any_size):
    """Boxes shrink and grow, and images of what was there must not stay."""
    shape, right = (121, 20), np.array([1.0, 0.0])
    light = lights((56, 9), shape, (0, 1), direction=-right)
    ends = [images_of(end, shape, (0,)) for end in ((42.5, 2.0), (42.5, 18.0))]
    mirrors = [
        {"kind": "segment", "start": start, "end": end, "albedo": 0.9} for start, end in zip(*ends)
    ]
    scene = scene_of(shape, (0, 1), light, with_walls=False, occluder=mirrors)
    scheme = propagators.create("dom4")
    half = assert_folding_changes_nothing(scene, (0, 1), scheme, (1, 1, 17, 40, 40), bands=1)
    cells = half.octree.levels[0].states[0]
    assert cells.swept < 0.9 * cells.sweepable
    middle = half.target.values[0, 60]
    assert np.abs(middle).max() > 0


#: The flux of grey light in three colours.
GREY = [1.0, 2.0, 4.0]


class TestColours:
    def test_one_spectrum(self, any_size):
        light = lights((5, 13), (14, 36), (0, 1), flux=GREY)
        half = assert_folding_changes_nothing(scene_of((14, 36), (0, 1), light), (0, 1))
        assert len(half._states) == 1

    def test_two_that_are_both_symmetric(self, any_size):
        light = lights((5, 13), (14, 36), (0, 1), flux=GREY)
        light += lights((3, 9), (14, 36), (0, 1), flux=[1.0, 0.0, 0.0])
        half = assert_folding_changes_nothing(scene_of((14, 36), (0, 1), light), (0, 1))
        assert len(half._states) == 2

    def test_two_of_which_one_is_along_fewer_axes(self, any_size):
        light = lights((5, 13), (14, 36), (0, 1), flux=GREY)
        light += lights((3, 9), (14, 36), (1,), flux=[1.0, 0.0, 0.0])
        assert_folding_changes_nothing(scene_of((14, 36), (0, 1), light), (1,))

    @pytest.mark.parametrize("other", [[0.2, 0.4, 0.8], [0.2, 0.4, 0.7]], ids=str)
    def test_coloured_walls(self, other, any_size):
        """All colours of all walls have to be images of each other."""
        shape, colours = (14, 36), [[0.2, 0.4, 0.8]] * 3 + [other]
        occluders = [
            {**wall, "albedo": albedo} for wall, albedo in zip(walls(shape, (0, 1)), colours)
        ]
        light = lights((5, 13), shape, (0, 1), flux=GREY)
        scene = scene_of(shape, (0, 1), light, with_walls=False, occluder=occluders)
        axes = (0, 1) if other == colours[0] else ()
        half = assert_folding_changes_nothing(scene, axes)
        assert len(half._states) == 3


class TestWhatIsNotFolded:
    @pytest.mark.parametrize("change", ["light", "wall", "albedo", "direction"])
    def test_scenes_that_are_not_quite_symmetric(self, change, any_size):
        shape = (14, 36)
        light, wall = lights((5, 13), shape, (0, 1)), walls(shape, (0, 1))
        if change == "light":
            light[1]["flux"] = 1.0 + 1e-9
        elif change == "wall":
            wall[1]["end"][0] += 1e-9
        elif change == "albedo":
            wall[1]["albedo"] += 1e-9
        else:
            light = lights((5, 13), shape, (0, 1), direction=[0.6, 0.8])
            light[1]["direction"] = [0.6, 0.8]
        scene = scene_of(shape, (), light, with_walls=False, occluder=wall)
        assert_folding_changes_nothing(scene, ())

    def test_light_that_differs_by_its_last_digits_is_the_same(self, any_size):
        light = lights((5, 13), (14, 36), (0, 1))
        light[1]["flux"] = 1.0 + 4e-15
        assert_folding_changes_nothing(scene_of((14, 36), (0, 1), light), (0, 1))

    def test_directions_turn_with_the_light(self, any_size):
        light = lights((5, 13), (14, 36), (0, 1), direction=np.array([0.6, 0.8]))
        assert_folding_changes_nothing(scene_of((14, 36), (0, 1), light), (0, 1), bands=4)

    def test_dropped_light(self, any_size):
        """Where light ends is known to the whole grid alone."""
        simulation = Simulation(scene_of((14, 36), (0, 1)), LPV, drop=1e-4)
        simulation.run(20)
        assert folded(simulation) == ()
        assert simulation.ledger.dropped != 0

    def test_small_grids_do_not_pay(self):
        small = Simulation(scene_of((32, 32), (0, 1), with_walls=False), LPV)
        large = Simulation(scene_of((160, 160), (0, 1), with_walls=False), LPV)
        for simulation in (small, large):
            simulation.run(1)
        assert folded(small) == ()
        assert folded(large) == (0, 1)

    def test_rows_of_as_many_vectors_do_not_pay(self, any_size):
        """Eight numbers of 64 bits are a vector: half of 8 is as much work as all."""
        simulation = Simulation(scene_of((200, 8), (0, 1), with_walls=False), LPV)
        simulation.run(1)
        assert folded(simulation) == (0,)


def totals(simulation):
    return {name: float(flux) for name, flux in simulation.ledger.as_dict().items()}


class TestAnyOrder:
    def test_snapshots_before_and_after_folding(self, any_size):
        scene = scene_of((14, 36), (0, 1))
        simulation = Simulation(scene, LPV, levels=2)
        simulation.start()
        kept = [capture(simulation)]
        for _ in range(3):
            simulation.run(2)
            kept.append(capture(simulation))
        states = [simulation.merge().values]
        books = [totals(simulation)]
        for snapshot in (kept[0], kept[2], kept[1], kept[3], kept[0]):
            restore(simulation, snapshot)
            assert folded(simulation) == (() if snapshot is kept[0] else (0, 1))
            simulation.run(6 - simulation.iteration)
            states.append(simulation.merge().values)
            books.append(totals(simulation))
        for state, book in zip(states, books):
            np.testing.assert_array_equal(state, states[0])
            assert book == pytest.approx(books[0], rel=1e-13, abs=1e-13)

    def test_lights_that_move_are_looked_at_anew(self, any_size):
        shape = (14, 36)
        scenes = [scene_of(shape, axes) for axes in ((0, 1), (), (0,), (0, 1))]
        walled = [wall.model_dump() for wall in scenes[0].occluders]
        half, whole = both(scenes[0])
        for axes in ((0, 1), (), (0,), (0, 1)):
            light = lights((5, 13), shape, axes)
            scene = scene_of(shape, (), light, with_walls=False, occluder=walls(shape, (0, 1)))
            assert [wall.model_dump() for wall in scene.occluders] == walled
            for simulation in (half, whole):
                simulation.relight(scene)
                assert not simulation.accumulated.values.any()
                simulation.run(9)
            assert folded(half) == axes
            assert_agree(half, whole)

    @pytest.mark.parametrize("method", ["auto", "stepping"])
    @pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
    def test_converged_light_is_that_of_the_whole(self, blocking, method, any_size):
        half, whole = both(scene_of((14, 36), (0, 1)), blocking=blocking, levels=2)
        for simulation in (half, whole):
            simulation.run(5)
            simulation.solve(1e-10, method)
        assert folded(half) == ()
        assert_agree(half, whole)
        for simulation in (half, whole):
            simulation.run(5)
        assert folded(half) == (0, 1)
        assert_agree(half, whole)

    def test_a_level_that_was_stepped_by_halves_can_be_solved(self, any_size):
        """Its newest light is taken for what it begins with, as without halves."""
        half, whole = both(scene_of((14, 36), (0, 1)))
        fields = []
        for simulation in (half, whole):
            simulation.run(4)
            level = simulation.octree.levels[0]
            level.solve(1e-11, "auto")
            fields.append(level.values("total")[0])
        np.testing.assert_allclose(*fields, rtol=0, atol=1e-9 * np.abs(fields[1]).max())

    def test_walls_that_come_later(self, any_size):
        """The coarse level is halved without walls, unfolded for them, and halved again."""
        half, whole = both(scene_of((16, 64), (0, 1)), levels=2)
        for simulation in (half, whole):
            simulation.inject()
            simulation.downsample()
            with pytest.warns(match="geometry"):
                simulation.run(3)
        assert folded(half, 1)
        for simulation in (half, whole):
            simulation.downsample_geometry()
        assert folded(half, 1) == ()
        assert_agree(half, whole)
        for simulation in (half, whole):
            simulation.run(4)
        assert_agree(half, whole)

    def test_light_that_is_downsampled_on_its_way(self, any_size):
        half, whole = both(scene_of((16, 64), (0, 1)), levels=3)
        for simulation in (half, whole):
            simulation.inject()
            simulation.run(5)
            simulation.downsample_geometry()
            simulation.downsample()
            simulation.run(5)
        assert folded(half, 1)
        assert_agree(half, whole)


def test_small_grids_lose_no_time_looking_for_images(monkeypatch):
    """Counting a scheme's operations takes as long as three runs of four steps on 17² cells."""
    counted = []
    count = mirror_axes.written_operations
    monkeypatch.setattr(
        mirror_axes, "written_operations", lambda stencil: counted.append(1) or count(stencil)
    )
    simulation = Simulation(load_scene("fig5-one-light"), propagators.create("dom8"), bands=4)
    for _ in range(3):
        simulation.start()
        simulation.run(4)
    assert len(counted) == 1


def test_cascades(any_size, monkeypatch):
    scene = scene_of((32, 32), (0, 1))
    found = Cascade(scene, LPV, levels=2, cells=20)
    found.run(12)
    assert found._levels[0].light.fold.axes
    monkeypatch.setattr(mirror_axes, "FEWEST_CELLS", 10**9)
    expected = Cascade(scene, LPV, levels=2, cells=20)
    expected.run(12)
    for number in range(2):
        mine, all_ = found.accumulated(number).values, expected.accumulated(number).values
        np.testing.assert_allclose(mine, all_, rtol=0, atol=1e-13 * np.abs(all_).max())
        assert found.ledger(number).left == pytest.approx(expected.ledger(number).left, rel=1e-12)


@pytest.mark.parametrize("shape", [(40, 48), (41, 49)], ids=str)
def test_explain_says_what_was_saved(shape, any_size):
    scene = scene_of(shape, (0, 1))
    simulation = Simulation(scene, LPV)
    assert "images" not in {skip.name for skip in simulation.explain()}
    simulation.run(30)
    skips = {skip.name: skip for skip in simulation.explain()}
    kept = (-(-shape[0] // 2) * -(-shape[1] // 2)) / (shape[0] * shape[1])
    assert skips["images"].saved == pytest.approx(1 - kept)
    assert "along x and y" in skips["images"].reason
    lone = Scene.from_dict({"grid": {"shape": shape}, "light": lights((3, 3), shape, ())})
    simulation = Simulation(lone, LPV)
    simulation.run(30)
    assert "images" not in {skip.name for skip in simulation.explain()}
