"""Area lights: what a segment puts into which cells."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flatland.errors import InputError
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics
from flatland.injectors import AreaLight

GRID = Grid((12, 9), 0.5, (-1.0, 2.0))
BASIS = CircularHarmonics(3)
ROUNDING = 1e-12

#: Positions in cells, one cell away from the border: on borders, on halves, and anywhere.
inside = st.one_of(
    st.integers(4, 28).map(lambda quarter: quarter / 4),
    st.integers(0, 10**6).map(lambda part: 1 + 6 * part / 10**6),
)
points = st.tuples(inside, inside)
quick = settings(deadline=None, derandomize=True, max_examples=60)


def area(start, end, grid=GRID, flux=1.0):
    """An area light between two points in cells."""
    return AreaLight(start=tuple(grid.to_world(start)), end=tuple(grid.to_world(end)), flux=flux)


def lit(light, grid=GRID):
    """Flux per cell, {(i, j): flux}."""
    flux = light.inject(grid, BASIS)[0] * BASIS.flux_weight
    return {tuple(map(int, cell)): float(flux[tuple(cell)]) for cell in np.argwhere(flux)}


@quick
@given(points, points)
def test_any_light_keeps_its_flux(start, end):
    assume(start != end)
    assert sum(lit(area(start, end)).values()) == pytest.approx(1.0, abs=ROUNDING)


@quick
@given(points, points)
def test_light_lands_under_the_moved_segment(start, end):
    assume(start != end)
    light = area(start, end)
    first, last = GRID.to_cells([light.start, light.end]) + 0.5 * light.normal
    for cell in lit(light):
        middle = np.array(cell) + 0.5
        t = np.clip((middle - first) @ (last - first) / np.sum((last - first) ** 2), 0, 1)
        assert np.linalg.norm(first + t * (last - first) - middle) <= np.sqrt(0.5) + 1e-8


@pytest.mark.parametrize("ends", [((2, 3), (7, 4.5)), ((6.2, 7.1), (3.3, 1.2)), ((4, 1), (4, 7))])
def test_light_is_the_limit_of_many_points(ends):
    count = 40_000
    light = area(*ends)
    t = (np.arange(count) + 0.5)[:, None] / count
    world = np.array(light.start) * (1 - t) + np.array(light.end) * t
    cells = np.floor(GRID.to_cells(world) + 0.5 * light.normal).astype(int)
    sampled = np.zeros(GRID.shape)
    np.add.at(sampled, tuple(cells.T), 1 / count)
    exact = light.inject(GRID, BASIS)[0] * BASIS.flux_weight
    # A sample may fall on the wrong side of each of the few borders.
    np.testing.assert_allclose(exact, sampled, atol=2 / count)


@pytest.mark.parametrize(
    ("start", "end", "cells"),
    [
        ((2, 3), (4, 3), [(2, 3), (3, 3)]),
        ((4, 3), (2, 3), [(2, 2), (3, 2)]),
        ((2, 3), (2, 5), [(1, 3), (1, 4)]),
        ((2, 5), (2, 3), [(2, 3), (2, 4)]),
    ],
)
def test_light_on_a_cell_border_starts_in_the_cell_in_front(start, end, cells):
    assert list(lit(area(start, end))) == cells


@pytest.mark.parametrize("shift", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize(("start", "end", "row"), [(2, 4, 4), (4, 2, 2)])
def test_light_moved_onto_a_border_belongs_in_front_of_it(start, end, row, shift):
    light = area((start, 3.5 + shift), (end, 3.5 - shift))
    assert list(lit(light)) == [(2, row), (3, row)]


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0, 4.0])
def test_net_flux_is_that_of_a_lambertian_emitter(angle):
    along = np.array([np.cos(angle), np.sin(angle)])
    middle = np.array([5.0, 4.0])
    light = area(middle - along, middle + along)
    field = Field(GRID, BASIS, light.inject(GRID, BASIS))
    normal = np.array([-along[1], along[0]])
    # ∫ cos θ · cos θ / 2 dθ over the half circle
    np.testing.assert_allclose(field.net_flux().sum(axis=(1, 2)), np.pi / 4 * normal, atol=1e-12)


def test_radiance_gives_twice_length_times_radiance():
    light = AreaLight(start=(0.0, 3.0), end=(3.0, 7.0), radiance=(0.5, 2.0))
    assert light.spectrum == pytest.approx((5.0, 20.0))


@pytest.mark.parametrize(
    ("start", "end"),
    [((2, 9), (6, 9)), ((0, 2), (0, 5)), ((2, 8.8), (3, 8.9)), ((9, 0.5), (2, 0.5))],
)
def test_light_sent_out_of_the_grid_is_refused_and_its_mirror_image_is_not(start, end):
    with pytest.raises(InputError, match="out of the grid"):
        area(start, end).inject(GRID, BASIS)
    assert lit(area(end, start))


@pytest.mark.parametrize("start", [(-1, 3), (3, 9.01), (20, 20)])
def test_light_outside_the_grid_is_refused(start):
    with pytest.raises(InputError, match="must lie in the grid"):
        area(start, (4, 4)).inject(GRID, BASIS)


def test_basis_of_another_dimension_is_refused():
    from flatland.harmonics import SphericalHarmonics

    with pytest.raises(InputError, match="basis"):
        area((2, 2), (3, 3)).inject(GRID, SphericalHarmonics(2))
