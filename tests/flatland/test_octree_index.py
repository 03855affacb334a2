"""Which level a place is read from."""

import numpy as np
import pytest
from scenes import quiet, scene_of
from scipy.ndimage import maximum_filter

import propagators
from flatland.octree import level_index, most_levels

DOM8, LPV = propagators.create("dom8"), propagators.create("lpv")


def _lit(shape, *cells):
    lights = [{"kind": "cell", "cell": list(cell), "flux": 1.0} for cell in cells]
    return scene_of(lights, shape)


def _filled(scene, propagator, levels=None, **options):
    levels = levels or most_levels(scene.grid.shape)
    simulation = quiet(propagator, scene, levels=levels, **options)
    simulation.start()
    return simulation


def _by_hand(reached):
    """min over levels of i where level i has light, cell by cell; the last level elsewhere."""
    shape = reached[0].shape
    index = np.full(shape, len(reached) - 1)
    for cell in np.ndindex(shape):
        for level, mask in enumerate(reached):
            if mask[tuple(i >> level for i in cell)]:
                index[cell] = level
                break
    return index


@pytest.mark.parametrize("shape", [(8, 8), (12, 7), (5, 6, 4)], ids=str)
def test_finest_level_with_light_is_read(shape, rng):
    reached, size = [], shape
    for _ in range(most_levels(shape)):
        reached.append(rng.random(size) < 0.2)
        size = tuple(-(-n // 2) for n in size)
    np.testing.assert_array_equal(level_index(reached), _by_hand(reached))


def test_jump_of_the_thesis_figure_17():
    """Injected and downsampled: beside the middle of the tree, the finest meets the coarsest."""
    simulation = _filled(_lit((8, 8), (3, 3)), LPV)
    index = simulation.index
    assert simulation.levels == 4
    assert index[3, 3] == 0
    assert index[4, 3] == index[3, 4] == 3  # a jump over all levels
    assert list(index[:4, 3]) == [2, 2, 1, 0]  # on the other side, gradually


def test_symmetric_index_does_not_jump():
    index = _filled(_lit((8, 8), (3, 3)), LPV, index="symmetric").index
    assert list(index[3:, 3]) == [0, 1, 2, 2, 3]
    assert list(index[:4, 3]) == [2, 2, 1, 0]


@pytest.mark.parametrize("steps", [0, 1, 2, 3, 5, 9])
@pytest.mark.parametrize("shape", [(32, 32), (21, 16), (9, 8, 8)], ids=str)
def test_symmetric_index_is_finer_and_goes_level_by_level(shape, steps, rng):
    cells = rng.integers(0, shape, size=(3, len(shape)))
    scheme = DOM8 if len(shape) == 2 else propagators.create("dom26")
    plain, symmetric = (
        _filled(_lit(shape, *cells), scheme, index=strategy, bands=1)
        for strategy in ("finest", "symmetric")
    )
    plain.run(steps)
    symmetric.run(steps)
    assert np.all(symmetric.index <= plain.index)
    # Neighbours, diagonal ones included, differ by one at most.
    assert np.all(maximum_filter(symmetric.index, 3) - symmetric.index <= 1)


def test_symmetric_index_is_as_far_from_the_light_on_every_side():
    """A light in the middle of a grid that is not the middle of any tree."""
    index = _filled(_lit((21, 21), (10, 10)), LPV, levels=3, index="symmetric").index
    away = np.maximum(*np.abs(np.indices((21, 21)) - 10))
    assert np.all(index[away == 0] == 0)
    assert np.all(index[away == 1] == 1)
    assert np.all(index[away >= 4] == 2)


@pytest.mark.parametrize("steps", [2, 3, 4, 8])
@pytest.mark.parametrize(("name", "shape"), [("dom8", (32, 32)), ("dom26", (16, 16, 16))])
def test_symmetric_index_reads_no_dark_element_from_the_second_step_on(name, shape, steps, rng):
    """With schemes that send to all neighbours."""
    for _ in range(3):
        scene = _lit(shape, *rng.integers(0, shape, size=(2, len(shape))))
        simulation = _filled(scene, propagators.create(name), index="symmetric", bands=1)
        simulation.run(steps)
        index = simulation.index
        for level in np.unique(index):
            lit = simulation.level(level).accumulated.values[0] != 0
            cells = np.nonzero(index == level)
            assert lit[tuple(axis >> int(level) for axis in cells)].all()


class TestBound:
    """0 ≤ I ≤ l − 1 − ⌊log₂ k⌋ after k steps (the octree thesis 4.2)."""

    @pytest.mark.parametrize(("name", "shape"), [("dom8", (16, 16)), ("dom26", (8, 8, 8))])
    def test_holds_for_schemes_that_send_to_all_neighbours(self, name, shape):
        """From the worst place, a corner, in the open: that is where it is proved."""
        scheme = propagators.create(name)
        simulation = _filled(_lit(shape, (0,) * len(shape)), scheme, bands=1)
        for steps in range(1, 18):
            simulation.step()
            index = simulation.index
            assert index.min() == 0
            assert index.max() <= max(0, simulation.levels - 1 - int(np.log2(steps)))

    @pytest.mark.parametrize(("shape", "steps"), [((16, 16), 4), ((8, 8, 8), 2)])
    def test_fails_for_schemes_that_send_along_axes(self, shape, steps):
        """Level l − 1 − m has 2^m cells a side; corner to corner is D (2^m − 1) steps, not 2^m."""
        simulation = _filled(_lit(shape, (0,) * len(shape)), LPV, bands=1)
        simulation.run(steps)
        assert simulation.index.max() == simulation.levels - int(np.log2(steps))

    @pytest.mark.parametrize("shape", [(16, 16), (8, 8, 8)], ids=str)
    def test_with_the_right_count_of_steps_it_holds_along_axes(self, shape):
        """I ≤ l − 1 − ⌊log₂(k / D + 1)⌋."""
        simulation = _filled(_lit(shape, (0,) * len(shape)), LPV, bands=1)
        for steps in range(1, 16 * len(shape)):
            simulation.step()
            complete = int(np.log2(steps / len(shape) + 1))
            assert simulation.index.max() <= max(0, simulation.levels - 1 - complete)

    def test_fails_where_walls_keep_light_out(self):
        box = [[2.0, 2.0], [6.0, 2.0], [6.0, 6.0], [2.0, 6.0]]
        scene = scene_of([{"kind": "cell", "cell": [12, 12], "flux": 1.0}], (16, 16))
        scene = type(scene).from_dict(
            {**scene.to_dict(), "occluder": [{"kind": "polygon", "vertices": box}]}
        )
        simulation = _filled(scene, DOM8, bands=1)
        simulation.run(64)
        assert simulation.index[3, 3] > 0


@pytest.mark.parametrize("patience", [1.0, 2.5, 6.0])
def test_patience_reads_a_level_later(patience):
    """After k steps the index is what it was after k / patience of them."""
    scene = _lit((16, 16), (2, 9), (12, 1))
    patient, hasty = (_filled(scene, LPV, bands=1, patience=p) for p in (patience, 1.0))
    for steps in range(20):
        hasty.reset()
        hasty.start()
        hasty.run(int(steps / patience))
        np.testing.assert_array_equal(patient.index, hasty.index)
        patient.step()


@pytest.mark.parametrize("patience", [1.0, 3.0])
def test_index_never_grows(patience):
    scene = _lit((16, 16), (2, 9), (12, 1))
    simulation = _filled(scene, LPV, bands=1, patience=patience)
    previous = simulation.index
    for _ in range(20):
        simulation.step()
        assert np.all(simulation.index <= previous)
        previous = simulation.index


def test_nothing_injected_is_read_from_the_coarsest():
    simulation = quiet(LPV, _lit((8, 8), (1, 1)), levels=3)
    assert np.all(simulation.index == 2)


def test_without_downsampling_only_level_0_has_light():
    simulation = quiet(LPV, _lit((8, 8), (1, 1)), levels=3)
    simulation.inject()
    simulation.run(2)
    assert set(np.unique(simulation.index)) == {0, 2}
    assert not simulation.level(2).accumulated.values.any()
    np.testing.assert_array_equal(simulation.merge().values, simulation.accumulated.values)
