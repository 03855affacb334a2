"""A grid in uniform surroundings: every cell sends out what comes in."""

import numpy as np
import pytest

from flatland.scene import Scene
from flatland.simulation import Simulation
from propagators import create

SHAPE, SPACING, RADIANCE = (9, 6), 0.5, 0.25
EMPTY = Scene.from_dict(
    {
        "grid": {"shape": SHAPE, "spacing": SPACING},
        "light": [{"kind": "environment", "radiance": RADIANCE}],
    }
)
#: ∫ h (|cos ω| + |sin ω|) L dω
CELL_FLUX = 8 * SPACING * RADIANCE


def test_reference_is_uniform():
    field = create("analytic").solve(EMPTY, bands=5)
    np.testing.assert_allclose(field.scalar_flux(), CELL_FLUX, rtol=1e-12)
    np.testing.assert_allclose(field.net_flux(), 0, atol=1e-12)


@pytest.mark.parametrize("name", ["lpv", "lpv-2009", "dom4"])
def test_isotropic_light_of_every_axial_scheme_is_the_reference(name):
    """One band keeps flux alone: a cell gets a quarter of what each neighbour has, 2hL, and the
    border gives the cells behind it the same."""
    simulation = Simulation(EMPTY, create(name), bands=1)
    simulation.solve(1e-12)
    np.testing.assert_allclose(simulation.accumulated.scalar_flux(), CELL_FLUX, rtol=1e-9)
