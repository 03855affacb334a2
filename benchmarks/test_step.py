"""A full iteration (step, accumulate, ledger) against the traffic of its memory."""

from __future__ import annotations

import numpy as np
import pytest

import propagators
from flatland.harmonics import basis_for
from studies.bench.limits import best_seconds, numpy_step
from studies.bench.steps import step_seconds

_SIDE = 512
#: Bands: largest allowed ratio to the traffic alone (issue: 2 and 4).
_ALLOWED = {2: 2.0, 5: 4.0}
#: The same for 64³ cells and 2 bands; 26 neighbours cost 284 multiply-adds a cell, not traffic.
_ALLOWED_3D = {"lpv": 3.0, "dom6": 3.0, "dom26": 8.0}


@pytest.mark.parametrize("bands", _ALLOWED)
@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8"])
def test_iteration_is_near_the_memory_limit(name, bands, report):
    stencil = propagators.create(name).stencil(basis_for(2, bands))
    times = step_seconds(stencil, (_SIDE, _SIDE), repeats=40)
    step, cache, memory = times.step, times.same_arrays, times.main_memory
    cells = np.random.default_rng(1).random((stencil.basis.size, _SIDE, _SIDE), np.float32)
    plain = best_seconds(
        lambda: numpy_step(stencil, cells, np.empty_like(cells), np.zeros_like(cells)), 5
    )
    report(
        f"{name} {bands} bands, {_SIDE}², float32: {step * 1e6:.0f} µs an iteration = "
        f"{step / memory:.2f} x main memory limit, {step / cache:.2f} x traffic of the same "
        f"arrays; NumPy takes {plain / step:.0f} x as long"
    )
    assert step <= _ALLOWED[bands] * max(memory, cache)
    assert plain >= 10 * step


@pytest.mark.parametrize("name", _ALLOWED_3D)
def test_iteration_in_space_is_near_the_memory_limit(name, report):
    stencil = propagators.create(name).stencil(basis_for(3, 2))
    times = step_seconds(stencil, (64, 64, 64), repeats=40)
    step, cache, memory = times.step, times.same_arrays, times.main_memory
    report(
        f"{name} 2 bands, 64³, float32: {step * 1e6:.0f} µs an iteration = "
        f"{step / memory:.2f} x main memory limit, {step / cache:.2f} x traffic of the same arrays"
    )
    assert step <= _ALLOWED_3D[name] * max(memory, cache)
