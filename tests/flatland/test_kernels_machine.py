"""The sweep as a program: threads, memory, machine code, and where numbers lie."""

import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
from stepping import Stepper, neighbours, random_stencil

from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics
from flatland.kernels import Layout, compiler, sweep
from flatland.kernels.compiler import compile_text
from flatland.kernels.threads import thread_count

every_precision = pytest.mark.parametrize("dtype", [np.float64, np.float32])


@pytest.fixture
def eager_threads(monkeypatch):
    """Every call is worth sharing; returns a function that sets the number of threads."""
    monkeypatch.setattr(sweep, "_WORTH_SHARING_BATCH", -1)
    monkeypatch.setattr(sweep, "_WORTH_SHARING_CALL", -1)
    return lambda count: monkeypatch.setenv("FLATLAND_THREADS", str(count))


def scheme(rng, clamp=False):
    """A made-up 2D scheme over all 8 neighbours."""
    return random_stencil(rng, CircularHarmonics(2), neighbours(2), faces=2, clamp=clamp)


@pytest.mark.parametrize("threads", [2, 3, 7])
@pytest.mark.parametrize("clamp", [False, True], ids=["linear", "clamped"])
def test_threads_change_no_bit_of_the_light(threads, clamp, rng, eager_threads):
    stencil = scheme(rng, clamp)
    values, transmittance = rng.normal(size=(3, 5, 19)), rng.uniform(size=(8, 5, 19))
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
    """Reports of three numbers a step, and what Python has not yet tidied up: some 20 kB."""
    a_field = 3 * 8 * 128 * 128
    assert peak_of_steps((128, 128), rng) < a_field / 4


def test_same_sweep_is_compiled_once(rng):
    stencil = scheme(rng)
    first, second = Stepper(stencil, (4, 4)), Stepper(stencil, (4, 4))
    assert first.sweep.programs.code[0] is second.sweep.programs.code[0]


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
