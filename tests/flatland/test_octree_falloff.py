"""Light that fades per metre on every level: factors that follow from the scheme itself."""

import numpy as np
import pytest
from scenes import quiet, scene_of

import propagators
from flatland.harmonics import basis_for
from flatland.octree.falloff import fading, step_factors
from flatland.simulation import Simulation
from flatland.stencil import Stencil


def straight(factor):
    """One band, to the right only, times a factor."""
    basis = basis_for(2, 1)
    return Stencil(basis, np.array([[1, 0]]), np.full((1, 1, 1), factor))


def test_light_that_runs_straight_gets_powers_of_the_factor():
    assert fading(straight(0.8)) == pytest.approx(-np.log(0.8), rel=1e-12)
    found = 0.8 * np.array(step_factors(straight(0.8), 5, "metres"))
    np.testing.assert_allclose(found, 0.8 ** (2.0 ** np.arange(5)), rtol=1e-10)


def test_a_random_walk_loses_four_times_as_much_a_level():
    """LPV of one band: λ(μ) = p (1 + cosh μ) / 2, so μ = arccosh(2/p − 1)."""
    p = 0.999
    stencil = propagators.create("lpv", propagation_factor=p).stencil(basis_for(2, 1))
    mu = np.arccosh(2 / p - 1)
    assert fading(stencil) == pytest.approx(mu, rel=1e-9)
    factors = p * np.array(step_factors(stencil, 4, "metres"))
    np.testing.assert_allclose(factors, 2 / (1 + np.cosh(mu * 2.0 ** np.arange(4))), rtol=1e-9)
    np.testing.assert_allclose((1 - factors[1:3]) / (1 - factors[:2]), 4, rtol=0.02)


@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8", "lpv-2009"])
@pytest.mark.parametrize("bands", [1, 2, 4])
def test_schemes_that_lose_nothing_need_no_factor(name, bands):
    stencil = propagators.create(name).stencil(basis_for(2, bands))
    assert fading(stencil) == 0
    assert step_factors(stencil, 4, "metres") == (1.0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize("options", [{"normalization": "nvidia"}, {"normalization": "published"}])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_wave_along_an_axis_is_stationary_on_every_level(options, dimension):
    """S(x) = v e^{−μ x}, twice as steep in the cells of each further level."""
    stencil = propagators.create("lpv", **options).stencil(basis_for(dimension, 2))
    mu = fading(stencil)
    assert mu > 0.1
    for level, factor in enumerate(step_factors(stencil, 4, "metres")):
        scaled = stencil.scaled(factor)
        growth = np.exp(mu * 2**level * scaled.offsets[:, 0])
        values = np.linalg.eigvals(np.tensordot(growth, scaled.transfer, axes=1))
        assert np.abs(values).max() == pytest.approx(1, rel=1e-8)


def test_far_light_fades_alike_in_metres():
    """Slope of the logarithm, per cell of level 0, far from a lit side."""
    scheme = propagators.create("lpv", normalization="nvidia")
    wall = [{"kind": "wall", "side": "left", "flux": 1.0}]
    slopes = {}
    for falloff in ("cells", "metres"):
        simulation = Simulation(scene_of(wall, (64, 64)), scheme, levels=3, falloff=falloff)
        simulation.solve(1e-12)
        slopes[falloff] = []
        for level in range(3):
            flux = simulation.level(level).accumulated.scalar_flux()
            middle = np.log(flux[:, flux.shape[1] // 2])
            first, last = 24 >> level, 40 >> level
            slopes[falloff].append((middle[first] - middle[last]) / 16)
    np.testing.assert_allclose(slopes["metres"], slopes["metres"][0], rtol=0.03)
    # The thesis: what a step loses, it loses per cell. The grid's sides take their part as well.
    np.testing.assert_allclose(slopes["cells"] / slopes["cells"][0], [1, 1 / 2, 1 / 4], rtol=0.15)


def test_factors_reach_the_levels():
    scheme = propagators.create("lpv", normalization="nvidia")
    simulation = quiet(scheme, scene_of(), levels=3, falloff="metres")
    factors = simulation.octree.step_factors
    assert factors[0] == 1
    for level, factor in zip(simulation.octree.levels, factors):
        np.testing.assert_allclose(
            level.stencil.transfer, factor * simulation.stencil.transfer, rtol=1e-15
        )


def test_nothing_overflows_on_many_levels():
    stencil = propagators.create("lpv", normalization="published").stencil(basis_for(2, 2))
    factors = step_factors(stencil, 14, "metres")
    assert all(np.isfinite(factors))
    assert factors[-1] == 0 or factors[-1] < 1e-300
