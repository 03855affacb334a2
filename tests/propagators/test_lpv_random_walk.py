"""The cosine lobe makes LPV a random walk (numerics §3): light forgets where it came from.

Measured on the newest light (all flux that is still under way), weighted with its scalar flux.
What a lobe along x remembers of its direction after one step is the factor
λ = 4/√10 − 1/√2 = 0.5578: face by face, the flux of cos θ onto a face times the face's normal,
summed. A Lambertian source moves by 1/√2 cells in the first step, so its mean displacement tends
to 1/√2 / (1 − λ) = 1.5991 cells. Both hold for any number of bands, since by the symmetry of the
square only m = 1 of a lobe's odd harmonics is left.
"""

from functools import cache

import numpy as np
import pytest
from scenes import lobe_scene

import propagators
from flatland.simulation import Simulation

SIDE, MIDDLE = 161, 80
STEPS = (1, 2, 16, 32, 64, 128, 256)
#: Light that has left the grid by step 64, 128 and 256, which the measures miss.
LOST = {64: 1e-14, 128: 1e-11, 256: 1e-5}
#: Rounding of sums over the grid.
ROUNDING = 1e-10

MEMORY = 4 / np.sqrt(10) - 1 / np.sqrt(2)
LIMIT = 1 / np.sqrt(2) / (1 - MEMORY)
every_band = pytest.mark.parametrize("bands", [2, 3, 4, 5, 8])


@cache
def walk(bands, flux="transfer", accumulated=False):
    """Flux, mean displacement along the normal and mean squared distance, after each of STEPS."""
    simulation = Simulation(
        lobe_scene((SIDE, SIDE)), propagators.create("lpv", flux=flux), bands=bands
    )
    x = np.arange(SIDE) - MIDDLE
    rows = {}
    for step in STEPS:
        simulation.run(step - simulation.iteration)
        field = simulation.accumulated if accumulated else simulation.target
        light = field.scalar_flux()
        total = light.sum()
        square = (light * (x[:, None] ** 2 + x**2)).sum() / total
        rows[step] = total, (light * x[:, None]).sum() / total, square
    return rows


@every_band
def test_mean_displacement_stays_below_1_6_cells(bands):
    for step in (1, 2, 16, 32, 64):
        _, displacement, _ = walk(bands)[step]
        assert displacement == pytest.approx(LIMIT * (1 - MEMORY**step), abs=ROUNDING)
    assert walk(bands)[256][1] == pytest.approx(1.5991, abs=2e-4)


def test_accumulated_light_creeps_to_the_same_displacement():
    """Its mean over all steps so far, so the start is forgotten as 1/k."""
    for step in (1, 2, 16, 32, 64):
        _, displacement, _ = walk(2, accumulated=True)[step]
        expected = (LIMIT * (1 - MEMORY ** np.arange(step + 1))).mean()
        assert displacement == pytest.approx(expected, abs=ROUNDING)


@every_band
def test_radius_grows_like_the_square_root_of_the_steps(bands):
    steps = np.array([16, 32, 64, 128, 256])
    radii = np.sqrt([walk(bands)[step][2] for step in steps])
    exponent = np.polyfit(np.log(steps), np.log(radii), 1)[0]
    assert exponent == pytest.approx(0.5, abs=0.03), f"radii {radii}, exponent {exponent:.4f}"


@pytest.mark.parametrize("bands", [2, 3, 4])
def test_light_diffuses_by_2_31_squared_cells_a_step(bands):
    """Up to four bands the light of all cells together is isotropic after some steps.

    ⟨r²⟩ then grows by 1 + 2 Σ ⟨d_i·d_j⟩, with ⟨d_i·d_{i+1}⟩ = (4/π) atan(1/3)/√2 and a factor λ
    for every step in between.
    """
    growth = 1 + 2 * (4 / np.pi) * np.arctan(1 / 3) / np.sqrt(2) / (1 - MEMORY)
    rows = walk(bands)
    assert (rows[64][2] - rows[32][2]) / 32 == pytest.approx(growth, abs=1e-6)


def test_more_bands_change_the_spread_by_three_percent_at_most():
    """From five bands on m = 4 tells the axes from the diagonals; that is all bands do."""
    spread = {bands: walk(bands)[64][2] for bands in (2, 3, 4, 5, 8)}
    assert spread[3] == pytest.approx(spread[2], rel=ROUNDING)
    assert spread[4] == pytest.approx(spread[2], rel=ROUNDING)
    assert spread[8] == pytest.approx(spread[5], rel=ROUNDING)
    assert np.sqrt(spread[5] / spread[2]) == pytest.approx(0.9718, abs=1e-3)


@pytest.mark.parametrize("bands", [2, 3, 4])
def test_samples_walk_like_integrals(bands):
    """One sample a face shifts the mean displacement by 2 %, no more."""
    rows = walk(bands, "central")
    assert rows[64][1] == pytest.approx(1.5639, abs=5e-4)
    assert rows[32][1] == pytest.approx(rows[64][1], abs=1e-6)


def test_light_is_still_in_the_grid_when_it_is_measured():
    """Otherwise the border would hold the light back, and not the lobes."""
    for step, lost in LOST.items():
        assert 1 - walk(2)[step][0] < lost
