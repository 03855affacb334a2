"""The sweep against plain NumPy, in every corner of memory it has to get right."""

import os
import subprocess
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from stepping import Stepper, neighbours, plain_run, plain_step, random_stencil

from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from flatland.kernels import Layout, compiler, sweep
from flatland.kernels.compiler import compile_text
from flatland.kernels.threads import thread_count

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


@pytest.fixture
def eager_threads(monkeypatch):
    """Every call is worth sharing; returns a function that sets the number of threads."""
    monkeypatch.setattr(sweep, "_WORTH_SHARING_BATCH", -1)
    monkeypatch.setattr(sweep, "_WORTH_SHARING_CALL", -1)
    return lambda count: monkeypatch.setenv("FLATLAND_THREADS", str(count))


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


@pytest.mark.parametrize("threads", [2, 3, 7])
@linear_or_clamped
def test_threads_change_no_bit_of_the_light(threads, clamp, rng, eager_threads):
    stencil = scheme(rng, clamp)
    values, transmittance = random_case(rng, stencil, (5, 19), blocked=True)
    stepper = Stepper(stencil, (5, 19), transmittance)
    eager_threads(1)
    alone = stepper.steps(values, 4)
    eager_threads(threads)
    shared = stepper.steps(values, 4)
    np.testing.assert_array_equal(shared[0], alone[0])
    np.testing.assert_array_equal(shared[1], alone[1])
    for name in ("components", "squares", "left"):
        # Sums over cells are taken thread by thread, in another order.
        np.testing.assert_allclose(
            getattr(shared[2], name), getattr(alone[2], name), rtol=1e-12, atol=1e-12
        )


_GROWING_CREW = """
import numpy as np
from flatland.kernels import sweep
from flatland.harmonics import CircularHarmonics
from stepping import Stepper, neighbours, random_stencil
import os
sweep._WORTH_SHARING_BATCH = sweep._WORTH_SHARING_CALL = -1
stencil = random_stencil(np.random.default_rng(0), CircularHarmonics(1), neighbours(2))
stepper = Stepper(stencil, (8, 8))
for threads in (2, 4, 3):
    os.environ["FLATLAND_THREADS"] = str(threads)
    stepper.steps(np.ones((1, 8, 8)), 3)
"""


def test_number_of_threads_may_grow_while_a_program_runs():
    """Too few helper threads would wait for one another for ever."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", _GROWING_CREW]
    subprocess.run(command, env=environment, check=True, timeout=60)


@pytest.mark.parametrize("wanted", ["0", "-1", "two", "", "1.5", "²"])
def test_bad_number_of_threads_is_refused(wanted, monkeypatch):
    monkeypatch.setenv("FLATLAND_THREADS", wanted)
    with pytest.raises(InputError, match="FLATLAND_THREADS = .*whole number, at least 1"):
        thread_count()


def test_all_processors_work_unless_told_otherwise(monkeypatch):
    monkeypatch.delenv("FLATLAND_THREADS")
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 2, 5}, raising=False)
    assert thread_count() == 3


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


def peak_of_steps(shape, rng):
    """Bytes that 50 batches of steps held at most beyond what was there before."""
    stencil = scheme(rng)
    stepper = Stepper(stencil, shape)
    buffers = [stepper.buffer() for _ in range(3)]
    stepper.sweep.steps(*buffers, 16)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(50):
            stepper.sweep.steps(*buffers, 16)
        return tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()


def test_steps_allocate_no_fields(rng):
    """Only a report of three numbers a step is made; a field of the larger grid has 400 kB."""
    small, large = peak_of_steps((4, 4), rng), peak_of_steps((128, 128), rng)
    assert small < 8000
    assert large < small + 500


def test_same_sweep_is_compiled_once(rng):
    stencil = scheme(rng)
    first, second = Stepper(stencil, (4, 4)), Stepper(stencil, (4, 4))
    assert first.sweep._code is second.sweep._code


def test_forgotten_code_still_runs(rng, monkeypatch):
    """A sweep owns its machine code, whatever the memory of compiled texts drops."""
    monkeypatch.setattr(compiler, "_compiled", type(compiler._compiled)())
    monkeypatch.setattr(compiler, "_KEPT", 1)
    stencil = scheme(rng)
    values = rng.normal(size=(3, 4, 4))
    stepper = Stepper(stencil, (4, 4))
    before = stepper.step(values)
    Stepper(stencil, (4, 5))
    assert len(compiler._compiled) == 1
    np.testing.assert_array_equal(stepper.step(values), before)


def test_assembly_that_does_not_parse_is_an_error():
    with pytest.raises(RuntimeError, match="expected"):
        compile_text("this is no assembly")


@pytest.mark.parametrize("shape", [(1, 1), (5, 16), (3, 17), (2, 3, 5)], ids=str)
@every_precision
def test_layout_keeps_cells_apart(shape, dtype):
    """Every cell and coefficient has a place of its own, one step away from its neighbours."""
    layout = Layout(shape, 3, np.dtype(dtype))
    buffer = layout.allocate()
    view = layout.view(buffer)
    view[...] = 1 + np.arange(view.size).reshape(view.shape)
    places = layout.index(np.argwhere(np.ones(shape)))
    for k in range(3):
        found = buffer[places + k * layout.component_stride]
        np.testing.assert_array_equal(found, view[k].ravel())
    for offset in neighbours(len(shape)):
        ends = places + layout.shift(offset) + 2 * layout.component_stride
        assert np.all((places + layout.shift(offset) >= 0) & (ends < layout.size))
    assert np.count_nonzero(buffer) == view.size


@every_precision
def test_rows_are_aligned_to_vectors(dtype):
    layout = Layout((5, 17), 3, np.dtype(dtype))
    buffer = layout.allocate()
    assert all(layout.view(buffer)[k, i].ctypes.data % 64 == 0 for k in range(3) for i in range(5))
