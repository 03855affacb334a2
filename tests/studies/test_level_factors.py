"""What factor a level needs: fitted, and from what a scheme remembers."""

from functools import cache

import numpy as np
import pytest

import propagators
from flatland.harmonics import basis_for
from flatland.scene import Scene
from studies.level_factors import factor_near_border, fit_level_factors, light_memory

#: 2D, N = 64: one area light of 16 cells near the lower edge; the upper three quarters count.
ROOM = Scene.from_dict(
    {
        "grid": {"shape": [64, 64]},
        "light": [{"kind": "area", "start": [24.0, 2.0], "end": [40.0, 2.0], "flux": 16.0}],
    }
)
UPPER = np.zeros((64, 64), bool)
UPPER[:, 16:] = True


@cache
def fits(name):
    """Of levels 1, 2 and 3."""
    return fit_level_factors(ROOM, propagators.create(name), 2, 4, UPPER, 1e-6)


class TestDom:
    def test_flux_takes_the_mismatch_of_level_1_from_a_half_to_a_few_percent(self):
        fit = fits("dom8")[0]
        assert fit.error_mean == pytest.approx(0.49, abs=0.005)
        assert fit.error_flux == pytest.approx(0.03, abs=0.005)

    @pytest.mark.parametrize("name", ["dom4", "dom8"])
    def test_factors_are_powers_of_two(self, name):
        first, second, _ = fits(name)
        assert first.fitted == pytest.approx(2, rel=0.02)
        assert second.fitted == pytest.approx(4, rel=0.05)

    def test_light_of_dom_runs_straight(self):
        for bands in (2, 4):
            for name in ("dom4", "dom8"):
                stencil = propagators.create(name).stencil(basis_for(2, bands))
                assert light_memory(stencil) == (np.inf, np.inf)
        assert factor_near_border(3, 2.5, 0.5, np.inf) == 8.0


class TestMemory:
    def test_a_lobe_of_lpv_gets_as_far_as_its_random_walk_says(self):
        """m is the closed form of the mean displacement (test_lpv_random_walk)."""
        forgotten = 4 / np.sqrt(10) - 1 / np.sqrt(2)
        memory, beyond = light_memory(propagators.create("lpv").stencil(basis_for(2, 2)))
        assert memory == pytest.approx(1 / np.sqrt(2) / (1 - forgotten), abs=1e-6)
        assert 1 < beyond < 1.5

    def test_without_directions_nothing_is_remembered(self):
        """One band: a plain random walk; light vanishes where it would be absorbed, at -1/2."""
        memory, beyond = light_memory(propagators.create("dom4").stencil(basis_for(2, 1)))
        assert memory == pytest.approx(0, abs=1e-6)
        assert beyond == pytest.approx(0.5, abs=1e-6)

    def test_space_is_remembered_for_less_long(self):
        memory, _ = light_memory(propagators.create("lpv").stencil(basis_for(3, 2)))
        assert memory == pytest.approx(0.9276, abs=1e-4)


class TestLpv:
    @pytest.mark.parametrize(("name", "within"), [("lpv", 0.07), ("lpv-2009", 0.08)])
    def test_near_a_border_factors_follow_from_the_memory(self, name, within):
        """The lit row is 2.5 cells above the border, on coarse levels 1.5, 0.5 and 0.5."""
        stencil = propagators.create(name).stencil(basis_for(2, 2))
        memory = sum(light_memory(stencil))
        for fit, height in zip(fits(name), (1.5, 0.5, 0.5)):
            expected = factor_near_border(fit.level, 2.5, height, memory)
            assert expected > 1.1 * 2**fit.level
            assert fit.fitted == pytest.approx(expected, rel=within)

    @pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.slow)])
    def test_far_from_borders_they_tend_to_powers_of_four(self, dimension):
        """Diffusion: per cell of twice the size, light spreads a quarter as fast per area."""
        found = []
        for side in (32, 64, 128) if dimension == 2 else (16, 32):
            cells = [side // 2 + np.array(c) - 2 for c in np.ndindex((4,) * dimension)]
            lights = [{"kind": "cell", "cell": cell.tolist(), "flux": 1.0} for cell in cells]
            scene = Scene.from_dict({"grid": {"shape": [side] * dimension}, "light": lights})
            lpv = propagators.create("lpv")
            found.append([fit.fitted for fit in fit_level_factors(scene, lpv, 2, 3)])
        short = 4.0 ** np.arange(1, 3) / np.array(found)  # 1 would be the limit
        assert np.all(short > 1)
        assert np.all(np.diff(short, axis=0) < 0)
        if dimension == 2:
            assert short[-1, 0] < 1.03

    def test_flux_alone_is_not_enough_and_the_fitted_factor_is(self):
        fit = fits("lpv")[0]
        assert fit.error_flux > 0.2
        assert fit.error_fitted < 0.035


def test_fits_report_the_coefficients_as_well():
    fit = fits("dom8")[0]
    assert fit.coefficients == pytest.approx(fit.fitted, rel=0.1)
    assert fit.error_fitted <= fit.error_flux <= fit.error_mean
