"""Area lights in 3D: what a polygon puts into which cells."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from sphere import cube_symmetries, representation

from flatland.errors import InputError
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from flatland.injection import inject
from flatland.injectors import AreaLight
from flatland.scene import Scene
from flatland.sources import Facet, PolygonSource

GRID = Grid((8, 7, 9), 0.5, (-1.0, 2.0, 3.0))
BASIS = SphericalHarmonics(3)
ROUNDING = 1e-12
SQUARE = np.array([[2.0, 3, 4], [4, 3, 4], [4, 5, 4], [2, 5, 4]])
#: Not convex, in a slanted plane.
ARROW = np.add(
    [1.5, 1.5, 2.0],
    np.array([[0, 0], [4, 0.5], [1.2, 1], [0.5, 4]]) @ np.array([[1, 0.1, 0.2], [0.2, 1, 0.7]]),
)

#: Positions in cells, one cell away from the border: on borders, on halves, and anywhere.
inside = st.one_of(
    st.integers(4, 24).map(lambda quarter: quarter / 4),
    st.integers(0, 10**6).map(lambda part: 1 + 5 * part / 10**6),
)
triangles = st.tuples(*[st.tuples(inside, inside, inside)] * 3)


def light_of(cells, grid=GRID, **keys):
    """An area light between points in cells."""
    vertices = tuple(map(tuple, grid.to_world(cells)))
    return AreaLight(vertices=vertices, **(keys or {"flux": 1.0}))


def lit(light, grid=GRID):
    """Flux per cell, {(i, j, k): flux}."""
    flux = light.inject(grid, BASIS)[0] * BASIS.flux_weight
    return {tuple(map(int, cell)): float(flux[tuple(cell)]) for cell in np.argwhere(flux)}


def spread(triangle):
    a, b, c = np.array(triangle)
    return np.linalg.norm(np.cross(b - a, c - a))


def scattered(polygon, count, generator):
    """Points over a planar polygon whose corners are seen from the first in order (fan)."""
    corners = np.array(polygon)
    fans = [corners[[0, i, i + 1]] for i in range(1, len(corners) - 1)]
    chosen = generator.choice(
        len(fans), count, p=np.array(list(map(spread, fans))) / sum(map(spread, fans))
    )
    u, v = generator.random((2, count))
    u, v = np.where(u + v > 1, (1 - u, 1 - v), (u, v))
    a, b, c = np.moveaxis(np.array(fans)[chosen], 1, 0)
    return a + u[:, None] * (b - a) + v[:, None] * (c - a)


@given(triangles)
def test_any_light_keeps_its_flux(triangle):
    assume(spread(triangle) > 1e-3)
    assert sum(lit(light_of(triangle)).values()) == pytest.approx(1.0, abs=ROUNDING)


@pytest.mark.parametrize("polygon", [SQUARE, ARROW[:3], np.add(SQUARE, [0.3, 0.2, 0.1])])
def test_light_is_the_limit_of_many_points(polygon, rng):
    count = 200_000
    light = light_of(polygon)
    points = scattered(polygon, count, rng) + 0.5 * light.normal
    sampled = np.zeros(GRID.shape)
    # Where the moved polygon lies on a border, its light belongs in front.
    np.add.at(sampled, tuple(np.floor(points + 1e-9 * light.normal).astype(int).T), 1 / count)
    exact = light.inject(GRID, BASIS)[0] * BASIS.flux_weight
    np.testing.assert_allclose(exact, sampled, atol=4 * 0.5 / np.sqrt(count))


def test_a_polygon_that_is_not_convex_is_the_sum_of_its_triangles():
    whole = light_of(ARROW, radiance=1.0)
    parts = [light_of(ARROW[list(three)], radiance=1.0) for three in ((0, 1, 2), (0, 2, 3))]
    pattern = sum(part.strength * part.inject(GRID, BASIS) for part in parts)
    assert whole.strength == pytest.approx(sum(part.strength for part in parts), rel=ROUNDING)
    np.testing.assert_allclose(whole.strength * whole.inject(GRID, BASIS), pattern, atol=ROUNDING)


def test_light_on_a_cell_border_starts_in_the_cell_in_front():
    cells = {(i, j) for i in (2, 3) for j in (3, 4)}
    assert set(lit(light_of(SQUARE))) == {(*ij, 4) for ij in cells}
    assert set(lit(light_of(SQUARE[::-1]))) == {(*ij, 3) for ij in cells}
    assert list(lit(light_of(SQUARE)).values()) == pytest.approx([0.25] * 4, rel=ROUNDING)


@pytest.mark.parametrize("shift", [0.0, 1e-12, -1e-12])
def test_light_moved_onto_a_border_belongs_in_front_of_it(shift):
    moved = np.add(SQUARE, [0, 0, 0.5 + shift])
    assert {k for _, _, k in lit(light_of(moved))} == {5}
    assert {k for _, _, k in lit(light_of(moved[::-1]))} == {3}


@pytest.mark.parametrize("polygon", [SQUARE, ARROW])
def test_net_flux_is_that_of_a_lambertian_emitter(polygon):
    light = light_of(polygon)
    field = Field(GRID, BASIS, light.inject(GRID, BASIS))
    # ∫ cos θ · cos θ / π dω over the half sphere
    found = field.net_flux().sum(axis=(1, 2, 3))
    np.testing.assert_allclose(found, 2 / 3 * light.normal, atol=ROUNDING)


def test_radiance_gives_pi_times_area_times_radiance():
    light = AreaLight(vertices=((0, 0, 0), (3.0, 0, 4.0), (0, 2.0, 0)), radiance=(0.5, 2.0))
    assert light.spectrum == pytest.approx((2.5 * np.pi, 10 * np.pi))


def test_twin_is_the_polygon_itself_with_its_flux():
    (twin,) = light_of(SQUARE, flux=(2.0, 3.0)).sources(GRID, 2)
    assert isinstance(twin, PolygonSource)
    np.testing.assert_allclose(GRID.to_cells(twin.vertices), SQUARE, atol=ROUNDING)
    np.testing.assert_array_equal(twin.spectrum, [2.0, 3.0])


def test_as_a_wall_it_is_black_and_open():
    wall = light_of(SQUARE).blocker(3)
    assert isinstance(wall, Facet)
    assert not wall.closed
    np.testing.assert_array_equal(wall.albedo, np.zeros(3))
    np.testing.assert_allclose(GRID.to_cells(wall.vertices), SQUARE, atol=ROUNDING)


@pytest.mark.parametrize("turn", list(cube_symmetries()), ids=str)
def test_a_turned_light_injects_the_turned_field(turn):
    grid = Grid((8, 8, 8))
    corners = ARROW
    turned = (corners - 4) @ turn.T + 4
    # A mirror image has its front on the other side, unless its corners run the other way.
    turned = turned if np.linalg.det(turn) > 0 else turned[::-1]
    before = light_of(corners, grid).inject(grid, BASIS)
    after = light_of(turned, grid).inject(grid, BASIS)
    cells = np.moveaxis(np.indices(grid.shape), 0, -1) - 3.5
    places = np.rint(cells @ turn.T + 3.5).astype(int)
    expected = np.zeros_like(before)
    mixed = np.einsum("ij,jxyz->ixyz", representation(BASIS, turn), before)
    expected[(slice(None), *np.moveaxis(places, -1, 0))] = mixed
    np.testing.assert_allclose(after, expected, atol=ROUNDING)


def test_lights_superpose_and_colours_are_apart():
    def scene(*lights):
        tables = [{"kind": "area", "vertices": v, "flux": flux} for v, flux in lights]
        return Scene.from_dict({"grid": {"shape": [8, 8, 8]}, "light": tables})

    one, other = (SQUARE, [1.0, 0.0, 2.0]), (ARROW, [0.5, 3.0, 0.0])
    both = inject(scene(one, other), BASIS).values
    apart = [inject(scene(light), BASIS).values for light in (one, other)]
    np.testing.assert_allclose(both, sum(apart), atol=ROUNDING)
    np.testing.assert_allclose(apart[0][2], 2 * apart[0][0], atol=ROUNDING)


@pytest.mark.parametrize("ends", [((2, 3), (7, 4.5)), ((6.2, 6.1), (3.3, 1.2)), ((4, 1), (4, 6))])
def test_a_light_that_spans_the_grid_is_its_flat_twin_in_every_layer(ends):
    flat, deep = Grid((9, 8)), Grid((9, 8, 5))
    (x0, y0), (x1, y1) = ends
    two = AreaLight(start=(x0, y0), end=(x1, y1), flux=1.0)
    corners = [(x1, y1, 0.0), (x0, y0, 0.0), (x0, y0, 5.0), (x1, y1, 5.0)]
    three = AreaLight(vertices=tuple(corners), flux=1.0)
    np.testing.assert_allclose(three.normal, [*two.normal, 0], atol=ROUNDING)
    basis = CircularHarmonics(1)
    expected = two.inject(flat, basis)[0] * basis.flux_weight
    found = three.inject(deep, BASIS)[0] * BASIS.flux_weight
    np.testing.assert_allclose(found, np.repeat(expected[..., None] / 5, 5, -1), atol=1e-11)


@pytest.mark.parametrize("side", [1e-3, 1e-8, 1e-10])
def test_tiny_lights_keep_their_flux(side):
    corners = np.array([3.3, 3.3, 3.3]) + side * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 1]])
    assert sum(lit(light_of(corners)).values()) == pytest.approx(1.0, abs=ROUNDING)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_light_sent_out_of_the_grid_is_refused_and_its_other_side_is_not(axis):
    top = np.roll(SQUARE - [1, 1, 0], axis - 2, axis=1)
    top[:, axis] = GRID.shape[axis]
    front, back = light_of(top), light_of(top[::-1])
    with pytest.raises(InputError, match="out of the grid"):
        front.inject(GRID, BASIS)
    assert lit(back)


def test_light_outside_the_grid_is_refused():
    with pytest.raises(InputError, match="^vertices = .*must lie in the grid"):
        light_of(np.add(SQUARE, [5, 0, 0])).inject(GRID, BASIS)
