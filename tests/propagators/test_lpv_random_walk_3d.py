"""LPV in space is a random walk as well (numerics §3): light forgets where it came from.

What a lobe along x remembers of its direction after one step is the flux of cos θ/(2π), its odd
part, onto every face, times the face's normal, summed: λ = 0.4026. A Lambertian source moves by
√2 acos(1/3)/π = 0.5541 cells in the first step (the vector angle of a cube's face, Lambert's
formula), so its mean displacement tends to 0.5541 / (1 − λ) = 0.9276 cells. By the symmetry of
the cube both hold for any number of bands.
"""

import numpy as np
import pytest
from scenes import lobe_scene
from sphere import over_polygon
from stepping import neighbours

import propagators
from flatland.simulation import Simulation

STEPS = 9
#: No light leaves this grid in so many steps.
SIDE = 2 * STEPS + 1
ROUNDING = 1e-12
FIRST = np.sqrt(2) * np.arccos(1 / 3) / np.pi


def memory():
    """λ, by quadrature over the faces of all six neighbours."""
    total = 0.0
    for along in neighbours(3, diagonal=False):
        for normal in neighbours(3, diagonal=False):
            if normal @ along < 0 or normal[0] == 0:
                continue
            centre, free = along + normal / 2, np.flatnonzero(normal == 0)
            corners = np.repeat(centre[None], 4, axis=0)
            corners[:, free] += 0.5 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
            directions, weights = over_polygon(corners)
            total += normal[0] * weights @ directions[:, 0] / (2 * np.pi)
    return total


def displacements(bands, **options):
    """Mean of x over the light of every step, along the source's normal [cells]."""
    simulation = Simulation(
        lobe_scene((SIDE,) * 3), propagators.create("lpv", **options), bands=bands
    )
    x = (np.arange(SIDE) - STEPS)[:, None, None]
    found = []
    for _ in range(STEPS):
        simulation.step()
        light = simulation.target.scalar_flux()
        found.append((light * x).sum() / light.sum())
    return np.array(found)


@pytest.mark.parametrize("bands", [2, 3, 5])
def test_mean_displacement_stays_below_one_cell(bands):
    steps, forgotten = np.arange(1, STEPS + 1), memory()
    expected = FIRST * (1 - forgotten**steps) / (1 - forgotten)
    np.testing.assert_allclose(displacements(bands), expected, rtol=0, atol=ROUNDING)
    assert FIRST / (1 - forgotten) == pytest.approx(0.9276, abs=5e-5)


@pytest.mark.parametrize(("sample", "limit"), [("face-centre", 0.9658), ("cone-centre", 1.0013)])
def test_samples_walk_a_little_further(sample, limit):
    """One sample a face shifts the limit by 4 or 8 %."""
    found = displacements(3, flux="central", sample=sample)
    ratio = (found[-1] - found[-2]) / (found[-2] - found[-3])
    assert found[-1] + (found[-1] - found[-2]) * ratio / (1 - ratio) == pytest.approx(
        limit, abs=5e-5
    )
