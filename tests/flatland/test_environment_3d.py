"""Environment light in 3D: what comes in through the border."""

import numpy as np
import pytest
import shapely
from sphere import cube_symmetries, representation
from walls3d import facet

from flatland.facets import vector_area
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import SphericalHarmonics
from flatland.injection import inject
from flatland.injectors import EnvironmentLight
from flatland.scene import Scene

GRID = Grid((5, 4, 6), 0.5, (1.0, -2.0, 3.0))
BASIS = SphericalHarmonics(4)
ROUNDING = 1e-12
SURFACE = 2 * (5 * 4 + 4 * 6 + 6 * 5) * 0.25


def field_of(radiance=1.0, grid=GRID):
    light = {"kind": "environment", "radiance": radiance}
    return inject(Scene.from_dict({"grid": grid, "light": [light]}), BASIS)


def area(source):
    return float(np.linalg.norm(vector_area(source.vertices)))


def test_flux_that_enters_is_pi_times_surface_times_radiance():
    assert field_of(3.0).total_flux() == pytest.approx(np.pi * SURFACE * 3.0)
    coloured = field_of((1.0, 0.5)).total_flux()
    np.testing.assert_allclose(coloured, np.pi * SURFACE * np.array([1.0, 0.5]))


def test_light_enters_border_cells_by_their_border_faces():
    flux = field_of().scalar_flux() / (np.pi * GRID.spacing**2)
    faces = sum(
        ((place == 0).astype(int) + (place == n - 1))
        for place, n in zip(np.indices(GRID.shape), GRID.shape)
    )
    np.testing.assert_allclose(flux, faces, atol=ROUNDING)


def test_lobe_is_the_clamped_cosine_inwards():
    expected = GRID.spacing**2 * BASIS.clamped_cosine([0.0, 0.0, -1.0])
    np.testing.assert_allclose(field_of().values[:, 2, 2, -1], expected, atol=ROUNDING)


def test_surroundings_look_the_same_from_every_side():
    values = field_of(grid=Grid((4, 4, 4))).values
    for turn in cube_symmetries():
        moved = values.transpose(0, *(1 + np.argmax(np.abs(turn), axis=1)))
        flips = [1 + axis for axis in range(3) if turn[axis].sum() < 0]
        turned = np.tensordot(representation(BASIS, turn), np.flip(moved, flips), 1)
        np.testing.assert_allclose(turned, values, atol=ROUNDING)


def test_twins_are_the_sides_of_the_grid():
    twins = EnvironmentLight(radiance=2.0).sources(GRID)
    assert len(twins) == 6
    assert sum(float(twin.spectrum[0]) for twin in twins) == pytest.approx(2 * np.pi * SURFACE)
    middle = np.array(GRID.origin) + 0.5 * np.array(GRID.extent)
    for twin in twins:
        assert vector_area(twin.vertices) @ (middle - twin.vertices[0]) > 0
        assert twin.spectrum[0] == pytest.approx(2 * np.pi * area(twin))


def on_top(*corners):
    """A facet on the upper side of z, from places across it in cells."""
    return facet([(x, y, 6.0) for x, y in corners], grid=GRID)


LID = on_top((0, 0), (3, 0), (3, 4), (0, 4))
HOLE = on_top((1, 1), (1, 3), (4, 3), (4, 1))
NEAR = facet([(0, 0, 5.9), (5, 0, 5.9), (5, 4, 5.9)], grid=GRID)
PARTLY = facet([(0, 0, 6), (5, 0, 6), (5, 4, 5.9)], grid=GRID)


@pytest.mark.parametrize(
    ("walls", "left"),
    [
        ([LID], 8.0),
        ([HOLE], 14.0),
        ([LID, HOLE], 6.0),
        ([NEAR, PARTLY], 20.0),
        ([on_top((-1, -1), (6, -1), (6, 5), (-1, 5))], 0.0),
        ([on_top((1e-11, 0), (5, -1e-11), (5, 2), (0, 2))], 10.0),
    ],
    ids=["lid", "hole", "both", "not on it", "closed", "rounding"],
)
def test_twins_leave_out_walls_that_lie_on_the_border(walls, left):
    light = EnvironmentLight(radiance=2.0)
    twins = light.twins(GRID, walls)
    top = [twin for twin in twins if np.all(twin.vertices[:, 2] == GRID.upper[2])]
    assert len(twins) - len(top) == 5
    assert sum(map(area, top)) / 0.25 == pytest.approx(left, abs=1e-9)
    for twin in top:
        assert vector_area(twin.vertices)[2] < 0  # shines down
        assert shapely.Polygon(twin.vertices[:, :2]).is_valid
        assert twin.spectrum[0] == pytest.approx(2 * np.pi * area(twin))
    assert light.twins(GRID, walls, part="bounce") == []


def test_pattern_is_that_of_unit_radiance():
    pattern = EnvironmentLight(radiance=2.0).inject(GRID, BASIS)
    assert Field(GRID, BASIS, pattern).total_flux() == pytest.approx(np.pi * SURFACE)
