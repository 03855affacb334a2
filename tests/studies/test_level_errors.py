"""Errors of octree levels: the thesis' as printed and corrected, and against the uniform grid."""

import itertools

import numpy as np
import pytest
from scenes import LPV, quiet, scene_of

import propagators
from flatland.errors import InputError
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.octree import halved
from flatland.simulation import Simulation
from studies.level_errors import (
    against_uniform,
    downsampled,
    error_history,
    thesis_errors,
    whole_cells,
)
from studies.metrics import relative_l2

LIGHTS = [{"kind": "area", "start": [5.0, 2.0], "end": [11.0, 2.0], "flux": 6.0}]
SCENE = scene_of(LIGHTS, (16, 16))


def field(shape, rng, dimension=2, bands=2):
    basis = basis_for(dimension, bands)
    return Field(Grid(shape), basis, rng.normal(size=(basis.size, *shape)))


def octree_of(finest, levels):
    return [downsampled(finest, number) for number in range(levels)]


class TestThesis:
    def test_levels_that_are_means_have_no_error(self, rng):
        errors = thesis_errors(octree_of(field((16, 16), rng), 5))
        assert not errors.absolute.any()
        assert errors.printed_relative == errors.corrected_absolute == 0

    @pytest.mark.parametrize(("dimension", "levels"), [(2, 3), (2, 5), (3, 2), (3, 4)])
    def test_sums_by_hand_and_the_printed_factor(self, dimension, levels, rng):
        """(2^D − 1) / (2^{Dl} − 2^D), 7 / (8^l − 8) in 3D, over all elements of a full octree."""
        size = 2 ** (levels - 1)
        fields = octree_of(field((size,) * dimension, rng, dimension), levels)
        fields = [
            Field(f.grid, f.basis, f.values + 0.1 * rng.normal(size=f.values.shape)) for f in fields
        ]
        absolute = relative = 0.0
        elements = 0
        for fine, coarse in itertools.pairwise(fields):
            mean = halved(fine.values, dimension)
            for cell in np.ndindex(coarse.grid.shape):
                place = (slice(None), *cell)
                error = np.abs(coarse.values[place] - mean[place]).max()
                absolute += error
                relative += error / np.abs(coarse.values[place]).max()
                elements += 1
        children = 2**dimension
        printed = (children - 1) / (children**levels - children)
        errors = thesis_errors(fields)
        assert errors.printed_absolute == pytest.approx(printed * absolute, rel=1e-12)
        assert errors.printed_relative == pytest.approx(printed * relative, rel=1e-12)
        assert errors.corrected_absolute == pytest.approx(absolute / elements, rel=1e-12)
        assert errors.corrected_relative == pytest.approx(relative / elements, rel=1e-12)
        # The printed count is that of O_0 … O_{l−2}: the mean comes out 2^D times too small.
        assert errors.corrected_absolute == pytest.approx(children * errors.printed_absolute)

    def test_means_per_level_add_up_to_the_whole(self, rng):
        fields = [field((16 >> i, 16 >> i), rng) for i in range(4)]
        errors = thesis_errors(fields)
        cells = np.array([64, 16, 4])
        assert errors.corrected_absolute == pytest.approx(errors.absolute @ cells / cells.sum())
        assert errors.corrected_relative == pytest.approx(errors.relative @ cells / cells.sum())

    def test_dark_elements_have_no_relative_error(self):
        simulation = quiet(LPV, SCENE, levels=4)
        simulation.start()
        fields = [simulation.level(number).accumulated for number in range(4)]
        errors = thesis_errors(fields)
        # Factor 2 a level: lit elements differ from the mean of their children by half.
        lit = [np.abs(f.values).max(axis=0) > 0 for f in fields[1:]]
        expected = [0.5 * mask.mean() for mask in lit]
        np.testing.assert_allclose(errors.relative, expected)

    def test_half_covered_elements_do_not_count(self, rng):
        fields = octree_of(field((7, 6), rng), 3)
        fields[1].values[:, -1, :] += 100.0
        assert thesis_errors(fields).absolute[0] == 0

    def test_one_level_has_nothing_to_be_compared_with(self, rng):
        with pytest.raises(InputError, match="levels = 1: must be at least 2"):
            thesis_errors([field((4, 4), rng)])


def test_whole_cells_have_all_their_children():
    mask = np.ones((7, 8), bool)
    mask[0, 0] = False
    expected = np.ones((4, 4), bool)
    expected[0, 0] = expected[3] = False
    np.testing.assert_array_equal(whole_cells(mask, 1), expected)
    np.testing.assert_array_equal(whole_cells(mask, 0), mask)


def test_uniform_errors_are_measured_on_the_levels_own_cells(rng):
    finest = field((16, 16), rng)
    fields = octree_of(finest, 4)
    fields[2] = Field(fields[2].grid, finest.basis, 1.1 * fields[2].values)
    errors = against_uniform(fields, finest)
    assert errors[1]["coefficients"] == 0
    assert errors[2]["coefficients"] == pytest.approx(0.1)
    assert errors[2]["best_scale"] == pytest.approx(1 / 1.1)
    assert errors[2]["infinity_mean"] == pytest.approx(0.1)


def test_a_mask_leaves_cells_out(rng):
    finest = field((16, 16), rng)
    fields = octree_of(finest, 3)
    for level in fields:
        level.values[:, : level.grid.shape[0] // 2] += 1.0
    mask = np.zeros((16, 16), bool)
    mask[8:] = True
    clean = octree_of(finest, 1)[0].values.copy()
    clean[:, :8] -= 1.0
    uniform = Field(finest.grid, finest.basis, clean)
    assert against_uniform(fields, uniform, mask)[2]["coefficients"] == pytest.approx(0, abs=1e-14)
    assert against_uniform(fields, uniform)[2]["coefficients"] > 0.1


class TestHistory:
    def test_every_row_is_what_a_run_of_that_many_steps_gives(self):
        data = error_history(SCENE, LPV, 2, 4, 5)
        assert dict(data.sizes) == {"iteration": 6, "level": 4}
        uniform = Simulation(SCENE, LPV)
        uniform.solve()
        for steps in (0, 5):
            run = Simulation(SCENE, LPV, levels=4)
            run.run(steps)
            row = data.sel(iteration=steps)
            merged = relative_l2(run.merge(), uniform.accumulated)
            assert float(row["merged"]) == pytest.approx(merged, rel=1e-12)
            fields = [run.level(number).accumulated for number in range(4)]
            thesis = thesis_errors(fields)
            assert float(row["printed_absolute"]) == pytest.approx(thesis.printed_absolute)
            assert float(row["corrected_relative"]) == pytest.approx(thesis.corrected_relative)
            exact = downsampled(uniform.accumulated, 2)
            error = relative_l2(fields[2], exact)
            assert float(row["coefficients"].sel(level=2)) == pytest.approx(error)

    def test_the_thesis_measure_blames_light_for_being_ahead(self):
        """Its section 7: compared with children that are still dark, a level looks wrong.

        In the first steps level 2 gets nearer to the uniform solution, and is nearer to it than
        level 0; by the thesis' measure it gets worse.
        """
        data = error_history(SCENE, propagators.create("dom8"), 2, 4, 12)
        thesis = data["thesis_relative"].sel(level=2).values
        honest = data["coefficients"]
        assert np.all(np.diff(thesis[:4]) > 0)
        assert np.all(np.diff(honest.sel(level=2).values[:4]) < 0)
        assert np.all((honest.sel(level=2) < honest.sel(level=0)).values[1:8])

    def test_options_reach_the_simulation(self):
        plain = error_history(SCENE, LPV, 1, 3, 2, normalization="mean")
        other = error_history(SCENE, LPV, 1, 3, 2, level_factors=[1, 3, 7])
        assert float(plain["coefficients"][2, 1]) != float(other["coefficients"][2, 1])
        assert float(plain["coefficients"][2, 0]) == float(other["coefficients"][2, 0])
