"""Every kind of light: flux, exact twins, symmetry."""

import numpy as np
import pytest
from pydantic import ValidationError

from flatland.errors import InputError
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.injectors import INJECTORS, AreaLight, CellLight, WallLight
from flatland.sources import PointSource, PolygonSource, SegmentSource

GRID = Grid((7, 5), 0.5, (1.0, -2.0))
CUBE = Grid((4, 3, 5))
ROUNDING = 1e-12

LIGHTS = {
    "area": (AreaLight(start=(2.1, -1.2), end=(3.3, -0.7), flux=2.0), GRID),
    "isotropic cell": (CellLight(cell=(2, 3), flux=2.0), GRID),
    "lobe in a cell": (CellLight(cell=(2, 3), direction=(3.0, -4.0), flux=2.0), GRID),
    "wall": (WallLight(side="top", flux=2.0), GRID),
    "isotropic wall": (WallLight(side="left", flux=2.0, isotropic=True), GRID),
    "part of a wall": (WallLight(side="right", flux=2.0, first=1, last=3), GRID),
    "cell in 3D": (CellLight(cell=(3, 0, 4), direction=(1.0, 2.0, 2.0), flux=2.0), CUBE),
    "area in 3D": (
        AreaLight(vertices=((1.2, 1.0, 1.5), (3.0, 1.0, 1.5), (2.5, 2.0, 3.0)), flux=2.0),
        CUBE,
    ),
    "wall in 3D": (WallLight(side="front", flux=2.0), CUBE),
}
every_light = pytest.mark.parametrize(("light", "grid"), LIGHTS.values(), ids=LIGHTS)


def field_of(light, grid, bands=3):
    basis = basis_for(grid.dimension, bands)
    return Field(grid, basis, light.inject(grid, basis))


def twin_flux(source):
    """Flux of a source for unit spectrum."""
    if isinstance(source, SegmentSource | PolygonSource):
        return 1.0
    weight = np.sqrt(2 * np.pi if source.position.size == 2 else 4 * np.pi)
    return source.coefficients[0] * weight + source.lobe_flux


@every_light
def test_pattern_has_unit_flux(light, grid):
    assert field_of(light, grid).total_flux() == pytest.approx(1.0, abs=ROUNDING)


@every_light
@pytest.mark.parametrize("colours", [0, 3])
def test_twins_carry_the_flux_of_the_light(light, grid, colours):
    total = sum(twin_flux(source) * source.spectrum for source in light.sources(grid, colours))
    np.testing.assert_allclose(total, np.full(max(1, colours), 2.0), rtol=ROUNDING)


@every_light
def test_point_twins_sit_in_the_middle_of_the_lit_cells(light, grid):
    twins = [s for s in light.sources(grid) if isinstance(s, PointSource)]
    lit = np.argwhere(field_of(light, grid).scalar_flux())
    positions = sorted(tuple(twin.position) for twin in twins)
    assert not twins or positions == sorted(tuple(grid.cell_center(cell)) for cell in lit)


@every_light
def test_point_twins_project_to_the_pattern(light, grid):
    field = field_of(light, grid)
    for source in light.sources(grid):
        if not isinstance(source, PointSource):
            continue
        expected = np.zeros(field.basis.size)
        expected[: source.coefficients.size] = source.coefficients
        if source.lobe_direction is not None:
            expected += field.basis.lambertian(source.lobe_direction, source.lobe_flux)
        cell = tuple(np.floor(grid.to_cells(source.position)).astype(int))
        found = 2.0 * field.values[(slice(None), *cell)]
        np.testing.assert_allclose(found, source.spectrum[0] * expected, atol=ROUNDING)


@pytest.mark.parametrize(
    ("side", "inward"),
    [("left", (1, 0)), ("right", (-1, 0)), ("bottom", (0, 1)), ("top", (0, -1))],
)
def test_wall_shines_inwards_from_every_cell_of_its_side(side, inward):
    field = field_of(WallLight(side=side, flux=1.0), GRID)
    first, last = (0, -1) if side in ("left", "bottom") else (-1, 0)
    flux = np.moveaxis(field.scalar_flux(), 0 if inward[0] else 1, 0)
    assert (flux[first] > 0).all()
    assert not flux[last].any()
    # The mean cosine of a Lambertian emitter in 2D is π/4.
    np.testing.assert_allclose(
        field.net_flux().sum(axis=(1, 2)), np.pi / 4 * np.array(inward), atol=ROUNDING
    )


def test_part_of_a_wall_lights_its_cells_only():
    flux = field_of(WallLight(side="right", flux=1.0, first=1, last=3), GRID).scalar_flux()
    np.testing.assert_array_equal(np.argwhere(flux), [[6, 1], [6, 2], [6, 3]])


@pytest.mark.parametrize("direction", [(3.0, 4.0), (3e-200, 4e-200), (3e99, 4e99)])
def test_direction_is_normalised(direction):
    light = CellLight(cell=(1, 1), direction=direction, flux=1.0)
    np.testing.assert_allclose(light.sources(GRID)[0].lobe_direction, [0.6, 0.8], rtol=ROUNDING)


@pytest.mark.parametrize(
    ("light", "problem"),
    [
        (CellLight(cell=(7, 0), flux=1.0), "cell"),
        (CellLight(cell=(1, 1, 1), flux=1.0), "cell"),
        (CellLight(cell=(1, 1), direction=(1.0, 0.0, 0.0), flux=1.0), "direction"),
        (WallLight(side="front", flux=1.0), "side"),
        (WallLight(side="left", flux=1.0, last=5), "last"),
        (WallLight(side="left", flux=1.0, first=5), "first"),
    ],
)
def test_light_that_does_not_fit_the_grid_is_refused(light, problem):
    with pytest.raises(InputError, match=f"^{problem} = "):
        light.inject(GRID, basis_for(2, 2))


def test_part_of_a_wall_is_refused_in_3d():
    with pytest.raises(InputError, match="2D only"):
        WallLight(side="left", flux=1.0, last=1).inject(CUBE, basis_for(3, 2))


@pytest.mark.parametrize("kind", INJECTORS)
def test_every_key_has_a_meaning(kind):
    assert all(field.description for field in INJECTORS[kind].model_fields.values())


@pytest.mark.parametrize("kind", INJECTORS)
def test_registry_name_is_the_kind(kind):
    assert INJECTORS[kind].model_fields["kind"].default == kind


def test_lights_are_frozen():
    with pytest.raises(ValidationError):
        LIGHTS["area"][0].flux = 3.0
