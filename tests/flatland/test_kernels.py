"""The sweep against plain NumPy, in every corner of memory it has to get right."""

from dataclasses import replace

import numpy as np
import pytest
from stepping import Stepper, neighbours, plain_run, plain_step, random_stencil

from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from flatland.kernels import Layout, Sweep, shares, sweep

#: Rounding of a few steps of sums of up to 100 products of numbers near 1.
TOLERANCE = {np.float64: 1e-13, np.float32: 1e-5}
#: Widths below, at and above both vector lengths, 8 and 16, and grids with hardly any cell.
SHAPES_2D = [(1, 1), (1, 9), (9, 1), (4, 7), (3, 8), (2, 15), (3, 16), (5, 17), (2, 33)]
SHAPES_3D = [(1, 1, 1), (3, 1, 2), (2, 3, 17)]

every_precision = pytest.mark.parametrize("dtype", [np.float64, np.float32])
open_or_blocked = pytest.mark.parametrize("blocked", [False, True], ids=["open", "blocked"])
linear_or_clamped = pytest.mark.parametrize("clamp", [False, True], ids=["linear", "clamped"])


@pytest.fixture
def by_matrices(monkeypatch):
    """Sweeps by matrix products, as for stencils too large to be written out."""
    monkeypatch.setattr(sweep, "LARGEST_TEXT", 0)


def scheme(rng, clamp=False, bands=2):
    """A made-up 2D scheme over all 8 neighbours."""
    return random_stencil(rng, CircularHarmonics(bands), neighbours(2), faces=2, clamp=clamp)


def random_case(rng, stencil, shape, blocked=False):
    """Light, and the transmittance of a scene in which something blocks."""
    values = rng.normal(size=(stencil.basis.size, *shape))
    return values, rng.uniform(size=(len(stencil.offsets), *shape)) if blocked else None


def assert_steps_agree(stencil, values, transmittance, dtype, count=3):
    states, _ = plain_run(stencil, values, count, transmittance)
    stepper = Stepper(stencil, values.shape[1:], transmittance, dtype=dtype)
    newest, total, _ = stepper.steps(values, count)
    np.testing.assert_allclose(newest, states[-1], rtol=0, atol=TOLERANCE[dtype])
    np.testing.assert_allclose(total, sum(states[1:]), rtol=0, atol=TOLERANCE[dtype])


@pytest.mark.parametrize("shape", SHAPES_2D, ids=str)
@open_or_blocked
@linear_or_clamped
@every_precision
def test_sweep_does_what_a_plain_step_does(shape, blocked, clamp, dtype, rng):
    stencil = scheme(rng, clamp)
    assert_steps_agree(stencil, *random_case(rng, stencil, shape, blocked), dtype)


@pytest.mark.parametrize("shape", SHAPES_3D, ids=str)
@pytest.mark.parametrize("diagonal", [False, True], ids=["6 neighbours", "26 neighbours"])
@open_or_blocked
@every_precision
def test_sweep_does_what_a_plain_step_does_in_3d(shape, diagonal, blocked, dtype, rng):
    stencil = random_stencil(rng, SphericalHarmonics(2), neighbours(3, diagonal))
    assert_steps_agree(stencil, *random_case(rng, stencil, shape, blocked), dtype)


@pytest.mark.parametrize("twice", [True, False], ids=["with and without walls", "with walls alone"])
@pytest.mark.parametrize("shape", [(6, 70), (40, 32), (3, 4, 37)], ids=str)
@linear_or_clamped
@every_precision
def test_walls_in_few_places(shape, twice, clamp, dtype, rng, monkeypatch):
    """Most vectors of cells then go without τ."""
    if not twice:
        monkeypatch.setattr(shares, "LARGEST_TWICE", -1)
    basis = CircularHarmonics(2) if len(shape) == 2 else SphericalHarmonics(2)
    stencil = random_stencil(rng, basis, neighbours(len(shape)), faces=2, clamp=clamp)
    values, _ = random_case(rng, stencil, shape)
    tau = np.ones((len(stencil.offsets), *shape))
    tau[:, 2, 3] = rng.uniform(size=tau[:, 2, 3].shape)
    tau[1, ..., 20] = 0.0
    assert_steps_agree(stencil, values, tau, dtype)


@pytest.mark.parametrize("shape", [(5, 9), (4, 48), (3, 4, 33)], ids=str)
@every_precision
def test_open_links_change_no_bit(shape, dtype, rng):
    basis = CircularHarmonics(2) if len(shape) == 2 else SphericalHarmonics(2)
    stencil = random_stencil(rng, basis, neighbours(len(shape)))
    values, _ = random_case(rng, stencil, shape)
    tau = np.ones((len(stencil.offsets), *shape))
    plain = Stepper(stencil, shape, dtype=dtype).steps(values, 3)
    np.testing.assert_array_equal(
        Stepper(stencil, shape, tau, dtype=dtype).steps(values, 3)[1], plain[1]
    )
    # A wall in the corner, where light leaves the grid, is far from all cells that are looked at.
    tau[:, -1, ..., -1] = 0.5
    blocked = Stepper(stencil, shape, tau, dtype=dtype).steps(values, 1)[0]
    free = Stepper(stencil, shape, dtype=dtype).steps(values, 1)[0]
    np.testing.assert_array_equal(blocked[:, :-2], free[:, :-2])


def test_open_cells_cost_no_memory():
    stencil = random_stencil(np.random.default_rng(0), CircularHarmonics(1), neighbours(2))
    layout = Layout((64, 64), 1, np.dtype(np.float32))
    tau = np.ones((8, 64, 64))
    tau[0, 10, 10] = 0.0
    assert Sweep(stencil, layout, tau).transmittance.size == 64 * 4 + 8 * 16


@pytest.mark.parametrize("shape", [(2, 33), (5, 64), (3, 4, 37), (2, 3, 160)], ids=str)
@pytest.mark.parametrize("bands", [2, 3])
@open_or_blocked
@linear_or_clamped
@every_precision
def test_fields_larger_than_the_cache(shape, bands, blocked, clamp, dtype, rng, monkeypatch):
    """Written past the cache and, in space, a piece of a row at a time."""
    basis = CircularHarmonics(bands) if len(shape) == 2 else SphericalHarmonics(bands)
    stencil = random_stencil(rng, basis, neighbours(len(shape)), faces=2, clamp=clamp)
    values, tau = random_case(rng, stencil, shape, blocked)
    small = Stepper(stencil, shape, tau, dtype=dtype).steps(values, 3)
    monkeypatch.setattr(sweep, "last_cache_bytes", lambda: 0)
    stepper = Stepper(stencil, shape, tau, dtype=dtype)
    assert stepper.sweep.recipe.large
    large = stepper.steps(values, 3)
    np.testing.assert_array_equal(large[0], small[0])
    np.testing.assert_array_equal(large[1], small[1])
    np.testing.assert_allclose(large[2].components, small[2].components, rtol=1e-5)
    np.testing.assert_allclose(large[2].squares, small[2].squares, rtol=1e-5)
    assert_steps_agree(stencil, values, tau, dtype)


def test_large_fields_may_begin_anywhere(rng, monkeypatch):
    """A store past the cache takes whole vectors only; NumPy's own arrays begin elsewhere."""
    stencil = random_stencil(rng, SphericalHarmonics(2), neighbours(3))
    values, _ = random_case(rng, stencil, (3, 4, 37))
    monkeypatch.setattr(sweep, "last_cache_bytes", lambda: 0)
    stepper = Stepper(stencil, (3, 4, 37))
    expected = stepper.steps(values, 2)[1]

    def displaced():
        return np.zeros(stepper.layout.size + 1)[1:]

    monkeypatch.setattr(Layout, "allocate", lambda self: displaced())
    assert displaced().ctypes.data % 64
    np.testing.assert_array_equal(stepper.steps(values, 2)[1], expected)


@linear_or_clamped
def test_more_coefficients_than_registers_are_swept_in_parts(clamp, rng):
    offsets = neighbours(2, diagonal=False)
    stencil = random_stencil(rng, CircularHarmonics(9), offsets, faces=2, clamp=clamp)
    assert_steps_agree(stencil, *random_case(rng, stencil, (4, 9), blocked=True), np.float64)


@pytest.mark.parametrize("shape", [(1, 1), (4, 7), (40, 33), (3, 4, 5)], ids=str)
@open_or_blocked
@linear_or_clamped
@every_precision
def test_matrix_products_do_what_a_plain_step_does(shape, blocked, clamp, dtype, rng, by_matrices):
    basis = CircularHarmonics(2) if len(shape) == 2 else SphericalHarmonics(2)
    stencil = random_stencil(rng, basis, neighbours(len(shape)), faces=2, clamp=clamp)
    values, transmittance = random_case(rng, stencil, shape, blocked)
    assert_steps_agree(stencil, values, transmittance, dtype)
    assert Stepper(stencil, shape).sweep.by_matrices


def test_stencils_beyond_the_limit_are_swept_by_matrices(rng):
    """15 bands, 8 neighbours, no zero: 6728 couplings, against a limit of 6000."""
    stencil = random_stencil(rng, CircularHarmonics(15), neighbours(2))
    assert Stepper(stencil, (3, 3)).sweep.by_matrices
    assert_steps_agree(stencil, *random_case(rng, stencil, (3, 3)), np.float64)


@pytest.mark.parametrize("shape", [(3, 8), (4, 7), (2, 3, 5)], ids=str)
@linear_or_clamped
def test_border_stays_zero(shape, clamp, rng):
    """What a step writes outside the grid would come back with the next one."""
    basis = CircularHarmonics(2) if len(shape) == 2 else SphericalHarmonics(2)
    stencil = random_stencil(rng, basis, neighbours(len(shape)), faces=2, clamp=clamp)
    stepper = Stepper(stencil, shape)
    buffers = [stepper.buffer(rng.normal(size=(basis.size, *shape))) for _ in range(3)]
    stepper.sweep.steps(*buffers, 3)
    for buffer in buffers:
        stepper.layout.view(buffer)[...] = 0
        assert not buffer.any()


@open_or_blocked
@linear_or_clamped
def test_a_batch_is_its_single_steps_bit_for_bit(blocked, clamp, rng):
    stencil = scheme(rng, clamp)
    values, transmittance = random_case(rng, stencil, (6, 11), blocked)
    stepper = Stepper(stencil, (6, 11), transmittance)
    newest, total, sums = stepper.steps(values, 5)
    source, target, single_total = stepper.buffer(values), stepper.buffer(), stepper.buffer()
    for k in range(5):
        report = stepper.sweep.steps(source, target, single_total, 1)
        source, target = target, source
        np.testing.assert_array_equal(report.components[0], sums.components[k])
        np.testing.assert_array_equal(report.squares[0], sums.squares[k])
        np.testing.assert_array_equal(report.left[0], sums.left[k])
    np.testing.assert_array_equal(stepper.layout.view(source), newest)
    np.testing.assert_array_equal(stepper.layout.view(single_total), total)


@pytest.mark.parametrize("shape", [(4, 7), (9, 1), (2, 3, 5)], ids=str)
@open_or_blocked
@linear_or_clamped
@pytest.mark.parametrize("written_out", [True, False], ids=["written out", "by matrices"])
def test_steps_report_what_happened(shape, blocked, clamp, written_out, rng, monkeypatch):
    if not written_out:
        monkeypatch.setattr(sweep, "LARGEST_TEXT", 0)
    basis = CircularHarmonics(2) if len(shape) == 2 else SphericalHarmonics(2)
    stencil = random_stencil(rng, basis, neighbours(len(shape)), faces=2, clamp=clamp)
    values, transmittance = random_case(rng, stencil, shape, blocked)
    states, steps = plain_run(stencil, values, 3, transmittance)
    _, _, sums = Stepper(stencil, shape, transmittance, sums=(0, 2)).steps(values, 3)
    content = [state.reshape(len(state), -1).sum(axis=1)[[0, 2]] for state in states[1:]]
    expected = {
        "components": content,
        "squares": [np.square(state).sum() for state in states[1:]],
        "left": [step.left for step in steps],
    }
    if clamp:
        expected["sent"] = [step.sent for step in steps]
    for name, numbers in expected.items():
        np.testing.assert_allclose(getattr(sums, name), numbers, atol=1e-12, err_msg=name)
    assert (sums.sent is None) is not clamp


@open_or_blocked
@pytest.mark.parametrize("written_out", [True, False], ids=["written out", "by matrices"])
@every_precision
def test_combination_for_solvers(blocked, written_out, dtype, rng, monkeypatch):
    """f₀ S + f₁ X + f₂ A S, with X left as it is."""
    if not written_out:
        monkeypatch.setattr(sweep, "LARGEST_TEXT", 0)
    stencil = scheme(rng)
    values, transmittance = random_case(rng, stencil, (5, 17), blocked)
    rest = rng.normal(size=values.shape)
    stepper = Stepper(stencil, (5, 17), transmittance, dtype=dtype)
    source, other, target = map(stepper.buffer, (values, rest, 0.0))
    kept = other.copy()
    stepper.sweep.combine(0.5, -2.0, 3.0, source, other, target)
    expected = 0.5 * values - 2 * rest + 3 * plain_step(stencil, values, transmittance).arrived
    found = stepper.layout.view(target)
    np.testing.assert_allclose(found, expected, rtol=0, atol=3 * TOLERANCE[dtype])
    np.testing.assert_array_equal(other, kept)


def test_linear_twin_of_a_clamped_sweep(rng):
    stencil = scheme(rng, clamp=True)
    values, transmittance = random_case(rng, stencil, (4, 5), blocked=True)
    stepper = Stepper(stencil, (4, 5), transmittance)
    stepper.sweep = stepper.sweep.linear()
    expected = plain_step(replace(stencil, clamp=False), values, transmittance).arrived
    np.testing.assert_allclose(stepper.step(values), expected, atol=TOLERANCE[np.float64])
