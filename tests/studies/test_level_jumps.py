"""Jumps of the light where levels meet."""

import numpy as np
import pytest

import propagators
from flatland import load_scene
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.simulation import Simulation
from studies.level_jumps import level_jumps

BASIS = basis_for(2, 1)


def grey(flux):
    flux = np.asarray(flux, float)
    return Field(Grid(flux.shape), BASIS, flux[None] / BASIS.flux_weight)


def test_steps_at_a_border_by_hand():
    flux = np.array([[1.0, 1.0], [1.0, 2.0], [3.0, 3.0]])
    index = np.array([[0, 0], [0, 0], [1, 1]])
    jumps = level_jumps(grey(flux), index)
    assert jumps.borders == 2
    at = [2 / 2.0, 1 / 2.5]
    assert jumps.mean == pytest.approx(np.mean(at))
    assert jumps.largest == pytest.approx(1.0)
    within = [0, 1 / 1.5, 0, 1 / 1.5, 0]
    assert jumps.within == pytest.approx(np.mean(within))
    assert jumps.regained == 1.0
    assert np.isnan(jumps.excess)


def test_excess_is_what_the_reference_does_not_do():
    flux, index = np.array([[1.0], [3.0]]), np.array([[0], [1]])
    assert level_jumps(grey(flux), index, grey(flux)).excess == 0
    assert level_jumps(grey(flux), index, grey([[1.0], [1.0]])).excess == pytest.approx(1.0)


def test_one_level_has_no_borders():
    jumps = level_jumps(grey(np.ones((3, 4))), np.zeros((3, 4), int))
    assert (jumps.borders, jumps.mean, jumps.largest, jumps.regained) == (0, 0, 0, 0)


def test_dark_cells_do_not_jump():
    jumps = level_jumps(grey([[0.0, 0.0], [0.0, 1.0]]), np.array([[0, 1], [1, 2]]))
    assert jumps.largest == 2.0
    assert jumps.mean == 1.0


def test_colours_and_space_add_up(rng):
    basis = basis_for(3, 2)
    values = rng.random(size=(3, basis.size, 4, 3, 2))
    field = Field(Grid((4, 3, 2)), basis, values)
    total = Field(field.grid, basis, values.sum(axis=0))
    index = rng.integers(0, 2, size=(4, 3, 2))
    assert level_jumps(field, index).mean == pytest.approx(level_jumps(total, index).mean)


class TestFigure14:
    """Light that has nearly died out regains intensity where a coarser level begins."""

    @staticmethod
    def _run(scheme, blend=None, **options):
        scene = load_scene("level-jump")
        simulation = Simulation(scene, scheme, levels=5, **options)
        simulation.run(2)
        uniform = Simulation(scene, scheme)
        uniform.solve()
        return level_jumps(simulation.merge(blend), simulation.index, uniform.accumulated)

    def test_intensity_jumps_and_a_blend_removes_the_jump(self):
        scheme = propagators.create("lpv", normalization="nvidia")
        hard, soft = self._run(scheme, normalization="mean"), self._run(scheme, 1.0)
        assert hard.mean > 5 * hard.within
        assert hard.excess > 0.5
        assert soft.mean < 0.25 * hard.mean
        assert soft.excess < 0.01

    def test_flux_normalization_halves_the_jump(self):
        scheme = propagators.create("lpv")
        mean, flux = (self._run(scheme, normalization=name) for name in ("mean", "flux"))
        assert flux.mean < 0.5 * mean.mean

    def test_light_is_regained(self):
        """Where a step leaves a sixth of the light, coarse light is ahead by whole powers of it."""
        jumps = self._run(propagators.create("lpv", normalization="published"))
        assert jumps.regained >= 0.5
        assert self._run(propagators.create("lpv"), normalization="mean").regained == 0
