"""Light on surfaces: exact where it must be, and never brighter for being dampened."""

from __future__ import annotations

import numpy as np
import pytest

from flatland import Field, Grid, InputError
from flatland.harmonics import basis_for
from flatland.surface_light import cosine_weights, damping_factor, interpolate, irradiance

RADIANCE = 3.0
#: Irradiance of a half space of unit radiance.
FULL = {2: 2.0, 3: np.pi}
GRIDS = {
    2: Grid((6, 5), 0.5, (1.0, -2.0)),
    3: Grid((4, 5, 3), 0.5, (1.0, -2.0, 0.5)),
}
OBLIQUE = {2: [0.6, 0.8], 3: [2 / 3, -2 / 3, 1 / 3]}


def uniform(dimension, bands):
    """The field of a constant radiance: L h^(dimension - 1) Σ|ω_i| in every cell."""
    grid, basis = GRIDS[dimension], basis_for(dimension, bands)
    size = RADIANCE * grid.spacing ** (dimension - 1)
    cell = basis.project(lambda unit: size * np.abs(unit).sum(axis=1))
    return Field(grid, basis, np.multiply.outer(cell, np.ones(grid.shape)))


def random_field(colours=0, dimension=2, bands=3, seed=1):
    grid, basis = GRIDS[dimension], basis_for(dimension, bands)
    shape = (colours,) * bool(colours) + (basis.size, *grid.shape)
    return Field(grid, basis, np.random.default_rng(seed).normal(size=shape))


def random_places(dimension=2, count=40, seed=2):
    """Points in the grid, and unit normals."""
    random, grid = np.random.default_rng(seed), GRIDS[dimension]
    normals = random.normal(size=(count, dimension))
    points = random.uniform(grid.origin, grid.upper, (count, dimension))
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize("bands", [1, 2, 4])
@pytest.mark.parametrize("method", ["distance", "cosine"])
def test_a_uniform_field_lights_axis_aligned_surfaces_as_it_must_in_2d(bands, method):
    # Below 5 bands the uniform field's cross-section, 8h over all directions, is a constant.
    grid, basis = GRIDS[2], basis_for(2, bands)
    cell = basis.isotropic(8 * grid.spacing * RADIANCE)
    field = Field(grid, basis, np.multiply.outer(cell, np.ones(grid.shape)))
    got = irradiance(field, random_places()[0], [0.0, 1.0], method)
    # At -n the constant is 4/π of the true cross-section; under the cosine this averages out.
    expected = 2 * RADIANCE * (4 / np.pi if method == "distance" else 1.0)
    np.testing.assert_allclose(got, expected, rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_cosine_of_a_uniform_field_converges_to_the_half_space(dimension):
    points = random_places(dimension)[0]
    expected = FULL[dimension] * RADIANCE
    errors = []
    for bands in (1, 9, 17):
        got = irradiance(uniform(dimension, bands), points, OBLIQUE[dimension], "cosine")
        errors.append(np.abs(got / expected - 1).max())
    assert errors[-1] < 2e-3, errors
    assert errors[-1] < errors[0], errors


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_uniform_field_at_half_a_cell_is_as_bright_as_its_cross_section(dimension):
    normal = np.array(OBLIQUE[dimension])
    got = irradiance(uniform(dimension, 33), random_places(dimension)[0], normal)
    expected = 2 ** (dimension - 1) * RADIANCE * np.abs(normal).sum()
    np.testing.assert_allclose(got, expected, rtol=5e-3)


def test_cosine_weights_of_one_band_are_known():
    # ∫ cos/(cos + |sin|) over a half circle is π/2.
    weight = cosine_weights(basis_for(2, 1), [1.0, 0.0])
    np.testing.assert_allclose(weight, np.pi / 2 / np.sqrt(2 * np.pi), rtol=1e-13)


@pytest.mark.parametrize("dimension", [2, 3])
def test_interpolation_is_exact_for_linear_fields(dimension):
    grid, basis = GRIDS[dimension], basis_for(dimension, 2)
    cells = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing="ij"), axis=-1)
    slopes = np.random.default_rng(3).normal(size=(basis.size, dimension))
    values = np.tensordot(slopes, grid.cell_center(cells), axes=(1, -1))
    points = np.random.default_rng(4).uniform(
        np.array(grid.origin) + grid.spacing / 2,
        np.array(grid.upper) - grid.spacing / 2,
        (30, dimension),
    )
    got = interpolate(Field(grid, basis, values), points)
    np.testing.assert_allclose(got, points @ slopes.T, atol=1e-13)


def test_the_border_is_lit_by_the_outermost_cells():
    field = random_field(colours=2)
    got = interpolate(field, [field.grid.origin, field.grid.upper])
    np.testing.assert_allclose(got[:, 0], field.values[:, :, 0, 0])
    np.testing.assert_allclose(got[:, 1], field.values[:, :, -1, -1])
    assert got.shape == (2, 2, field.basis.size)


@pytest.mark.parametrize("method", ["distance", "cosine"])
@pytest.mark.parametrize("damping", [False, True])
def test_a_mirrored_field_lights_mirrored_surfaces_alike(method, damping):
    field = random_field()
    turned = field.values[:, ::-1].copy()
    turned[1] *= -1  # cos θ changes sign under x -> -x, and so does sin 2θ
    turned[4] *= -1
    grid = field.grid
    points, normals = random_places()
    other = points.copy()
    other[:, 0] = grid.origin[0] + grid.upper[0] - points[:, 0]
    first = irradiance(field, points, normals, method, damping)
    second = irradiance(Field(grid, field.basis, turned), other, normals * [-1, 1], method, damping)
    assert first.max() > 0
    np.testing.assert_allclose(first, second, atol=1e-12)


@pytest.mark.parametrize("method", ["distance", "cosine"])
@pytest.mark.parametrize("colours", [0, 3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_damping_never_brightens(method, colours, dimension):
    field = random_field(colours, dimension)
    points, normals = random_places(dimension)
    bright = irradiance(field, points, normals, method)
    dim = irradiance(field, points, normals, method, damping=True)
    assert np.all((dim >= 0) & (dim <= bright))
    assert np.any(dim < bright)


@pytest.mark.parametrize("dimension", [2, 3])
def test_cosine_weights_are_as_good_as_they_say(dimension):
    # Turning a surface by a symmetry of the cell changes nothing for one band.
    weights = [
        cosine_weights(basis_for(dimension, 1), np.roll(OBLIQUE[dimension], shift) * sign)[0]
        for shift in range(dimension)
        for sign in (1, -1)
    ]
    np.testing.assert_allclose(weights, weights[0], rtol={2: 1e-13, 3: 1e-4}[dimension])


def test_damping_takes_light_from_behind_and_leaves_light_from_before():
    field = uniform(2, 2)
    values = field.values.copy()
    values[:, :3] = 0.0  # light for x > 2.5 alone
    lit = Field(field.grid, field.basis, values)
    edge = [[2.5, 0.0]]
    assert damping_factor(lit, edge, [[1.0, 0.0]])[0] == pytest.approx(1.0)
    assert damping_factor(lit, edge, [[-1.0, 0.0]])[0] == pytest.approx(0.0)


def test_damping_leaves_uniform_and_black_fields():
    points, normals = random_places()
    field = uniform(2, 3)
    np.testing.assert_allclose(damping_factor(field, points, normals), 1.0)
    black = Field(field.grid, field.basis, 0 * field.values)
    np.testing.assert_array_equal(irradiance(black, points, normals, damping=True), 0.0)


def test_an_offset_looks_before_the_surface():
    field = random_field()
    cell = field.grid.cell_center([2, 2])
    normal = np.array([0.0, 1.0])
    wall = cell - normal * field.grid.spacing / 2
    np.testing.assert_allclose(
        irradiance(field, [wall], normal, offset=0.5), irradiance(field, [cell], normal)
    )


@pytest.mark.parametrize(
    ("points", "normals", "method", "words"),
    [
        ([[0.0, 0.0]], [0.0, 1.0], "cosine", ["points", "[0.0, 0.0]", "outside"]),
        ([[np.nan, 0.0]], [0.0, 1.0], "cosine", ["points", "outside"]),
        ([2.0, 0.0], [0.0, 1.0], "cosine", ["points", "(M, 2)"]),
        ([[2.0, 0.0]], [0.0, 2.0], "cosine", ["normals", "length 1"]),
        ([[2.0, 0.0]], [[0.0, 1.0]] * 2, "cosine", ["normals", "(1, 2)"]),
        ([[2.0, 0.0]], [0.0, 1.0], "sine", ["method", "sine", "distance", "cosine"]),
    ],
)
def test_bad_surfaces_are_refused(points, normals, method, words):
    with pytest.raises(InputError) as caught:
        irradiance(random_field(), points, normals, method)
    for word in words:
        assert word in str(caught.value)
