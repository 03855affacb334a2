"""Environment light: what comes in through the border."""

import numpy as np
import pytest

from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics
from flatland.injection import inject
from flatland.injectors import EnvironmentLight
from flatland.scene import Scene

GRID = Grid((9, 6), 0.5, (1.0, -2.0))
BASIS = CircularHarmonics(5)
ROUNDING = 1e-12
PERIMETER = 2 * (9 + 6) * 0.5


def field_of(radiance=1.0, occluders=(), grid=GRID):
    light = {"kind": "environment", "radiance": radiance}
    scene = Scene.from_dict({"grid": grid, "light": [light], "occluder": list(occluders)})
    return inject(scene, BASIS)


def test_flux_that_enters_is_two_times_perimeter_times_radiance():
    assert field_of(3.0).total_flux() == pytest.approx(2 * PERIMETER * 3.0)
    np.testing.assert_allclose(
        field_of((1.0, 0.5)).total_flux(), 2 * PERIMETER * np.array([1.0, 0.5])
    )


def test_light_enters_border_cells_by_their_border_faces():
    flux = field_of().scalar_flux() / (2 * GRID.spacing)
    assert (flux[1:-1, 1:-1] == 0).all()
    np.testing.assert_allclose(flux[0, 1:-1], 1, rtol=1e-12)
    np.testing.assert_allclose(flux[1:-1, -1], 1, rtol=1e-12)
    np.testing.assert_allclose(flux[::8, ::5], 2, rtol=1e-12)


def test_lobe_is_the_clamped_cosine_inwards():
    expected = GRID.spacing * BASIS.clamped_cosine([1.0, 0.0])
    np.testing.assert_allclose(field_of().values[:, 0, 2], expected, atol=ROUNDING)


def test_surroundings_look_the_same_from_every_side():
    field = field_of()
    flux, net = field.scalar_flux(), field.net_flux()
    for axis in (0, 1):
        np.testing.assert_allclose(flux, np.flip(flux, axis), atol=ROUNDING)
        np.testing.assert_allclose(net[axis], -np.flip(net[axis], axis), atol=ROUNDING)
    square = field_of(grid=Grid((6, 6)))
    np.testing.assert_allclose(square.scalar_flux(), square.scalar_flux().T, atol=ROUNDING)
    np.testing.assert_allclose(square.net_flux()[0], square.net_flux()[1].T, atol=ROUNDING)


@pytest.mark.parametrize("depth", [0.0, 0.1])
def test_walls_at_the_border_keep_light_out(depth):
    # Along the left side, over the lower four of its six faces.
    lid = {"kind": "segment", "start": (1.0 + depth, -2.0), "end": (1.0 + depth, 0.0)}
    dark, bright = field_of(occluders=[lid]), field_of()
    lost = (bright.scalar_flux() - dark.scalar_flux()) / (2 * GRID.spacing)
    expected = np.zeros(GRID.shape)
    expected[0, :4] = 1
    np.testing.assert_allclose(lost, expected, atol=ROUNDING)


def test_twins_are_the_sides_without_the_walls_on_them():
    light = EnvironmentLight(radiance=2.0)
    assert sum(float(s.spectrum[0]) for s in light.sources(GRID)) == pytest.approx(4 * PERIMETER)
    walls = Scene.from_dict(
        {
            "grid": GRID,
            "occluder": [
                {"kind": "segment", "start": (2.0, 1.0), "end": (3.0, 1.0)},
                {"kind": "segment", "start": (2.5, 1.0), "end": (9.0, 1.0)},
                {"kind": "segment", "start": (1.0, -2.0), "end": (1.0, 1.0)},
                {"kind": "segment", "start": (2.0, 0.9), "end": (3.0, 1.0)},
            ],
        }
    ).segments()
    twins = light.twins(GRID, walls)
    lengths = sorted(float(np.hypot(*(twin.stop - twin.start))) for twin in twins)
    np.testing.assert_allclose(lengths, [1.0, 3.0, 4.5])
    middle = np.array([3.25, -0.5])
    for twin in twins:
        (x, y), way = twin.stop - twin.start, middle - twin.start
        assert x * way[1] - y * way[0] > 0  # the grid is on the left
        assert twin.spectrum[0] == pytest.approx(4 * np.hypot(x, y))
    assert light.twins(GRID, walls, part="bounce") == []


def test_pattern_is_that_of_unit_radiance():
    pattern = EnvironmentLight(radiance=2.0).inject(GRID, BASIS)
    assert Field(GRID, BASIS, pattern).total_flux() == pytest.approx(2 * PERIMETER)
