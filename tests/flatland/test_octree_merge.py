"""One field from many levels."""

import numpy as np
import pytest
from scenes import LPV, quiet, scene_of

from flatland.octree import blended, merged
from flatland.octree.downsampling import spread
from flatland.octree.sampling import sampled

SHAPE = (16, 12)
SIZES = [(16, 12), (8, 6), (4, 3), (2, 2), (1, 1)]


@pytest.fixture
def levels(rng):
    return [rng.normal(size=(3, *size)) for size in SIZES]


def _index(rng):
    """Levels in blobs, all of them present."""
    coarse = rng.integers(0, 5, size=(8, 6)).astype(np.int8)
    index = spread(coarse, 1, SHAPE)
    index[0, :5] = range(5)
    return index


def test_every_cell_is_read_from_its_level(levels, rng):
    index = _index(rng)
    found = merged(lambda number: levels[number], index)
    for cell in np.ndindex(SHAPE):
        level = index[cell]
        element = tuple(i >> level for i in cell)
        np.testing.assert_array_equal(found[(slice(None), *cell)], levels[level][(..., *element)])


def test_only_levels_that_are_read_are_asked_for(levels):
    index = np.zeros(SHAPE, np.int8)
    index[3:, :] = 2
    asked = []
    merged(lambda number: asked.append(number) or levels[number], index)
    assert set(asked) == {0, 2}


def test_a_constant_stays_that_constant(rng):
    constant = [np.full((2, *size), 0.3) for size in SIZES]
    for index in (_index(rng), np.zeros(SHAPE, np.int8), np.full(SHAPE, 4, np.int8)):
        np.testing.assert_array_equal(merged(lambda i: constant[i], index), 0.3)
        for width in (0.0, 0.7, 2.0):
            np.testing.assert_allclose(
                blended(lambda i: constant[i], index, width), 0.3, rtol=1e-14
            )


@pytest.mark.parametrize("width", [0.0, 1.0, 3.0])
def test_a_linear_field_stays_linear_between_centres(width):
    """Where interpolation has centres on both sides, fading changes nothing."""

    def plane(size, spacing):
        x, y = (np.indices(size) + 0.5) * spacing
        return (2 * x - 3 * y)[None]

    fields = [plane(size, 2**level) for level, size in enumerate([(32, 32), (16, 16), (8, 8)])]
    index = np.zeros((32, 32), np.int8)
    index[10:], index[20:] = 1, 2
    found = blended(lambda number: fields[number], index, width)
    inside = (slice(None), slice(2, -2), slice(2, -2))
    np.testing.assert_allclose(found[inside], fields[0][inside], atol=1e-12)


def test_blended_field_is_that_of_a_level_far_from_others(levels):
    index = np.zeros(SHAPE, np.int8)
    index[10:] = 1
    found = blended(lambda number: levels[number], index, 1.0)
    np.testing.assert_array_equal(found[:, :8], levels[0][:, :8])
    x, y = np.indices((3, 12)) + 0.5
    expected = sampled(levels[1], np.stack([x + 13, y]) / 2)
    np.testing.assert_allclose(found[:, 13:], expected, atol=1e-14)


def test_blending_removes_the_jump():
    """A bright and a dark level: no neighbours differ by more than the width lets them."""
    fields = [np.zeros((1, 32, 32)), np.ones((1, 16, 16))]
    index = np.zeros((32, 32), np.int8)
    index[16:] = 1
    hard = merged(lambda number: fields[number], index)
    soft = blended(lambda number: fields[number], index, 4.0)
    assert np.abs(np.diff(hard[0], axis=0)).max() == 1
    assert np.abs(np.diff(soft[0], axis=0)).max() == pytest.approx(1 / 8)
    np.testing.assert_array_equal(soft[0, 16:], 1)


def test_samples_at_centres_are_the_cells(rng):
    for shape in [(5, 4), (3, 4, 2), (1, 6)]:
        values = rng.normal(size=(2, 3, *shape))
        found = sampled(values, np.indices(shape) + 0.5)
        np.testing.assert_allclose(found, values, atol=1e-15)


def test_samples_between_centres_are_means(rng):
    values = rng.normal(size=(1, 6, 5))
    found = sampled(values, np.array([[2.0, 0.0], [1.5, 4.9]]))
    assert found[0, 0] == pytest.approx(values[0, 1:3, 1].mean())
    assert found[0, 1] == pytest.approx(values[0, 0, 4])  # beyond the outermost centres


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_merge_keeps_the_precision(precision):
    simulation = quiet(LPV, scene_of(), levels=3, precision=precision)
    simulation.run(2)
    assert simulation.merge().values.dtype == precision
    assert simulation.merge(1.0).values.dtype == precision
    assert simulation.merged.grid == simulation.scene.grid
