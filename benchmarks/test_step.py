"""A full iteration (step, accumulate, ledger) against the traffic of its memory."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import best_seconds
from limits import main_memory_bandwidth, numpy_step, traffic_seconds

import propagators
from flatland.harmonics import basis_for
from flatland.kernels import Layout, Sweep
from flatland.stencil import Stencil

_SIDE, _BATCH = 512, 16
#: Bands: largest allowed ratio to the traffic alone (issue: 2 and 4).
_ALLOWED = {2: 2.0, 5: 4.0}
#: The same for 64³ cells and 2 bands; 26 neighbours cost 284 multiply-adds a cell, not traffic.
_ALLOWED_3D = {"lpv": 3.0, "dom6": 3.0, "dom26": 8.0}


@pytest.mark.parametrize("bands", _ALLOWED)
@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8"])
def test_iteration_is_near_the_memory_limit(name, bands, report):
    stencil = propagators.create(name).stencil(basis_for(2, bands))
    step, cache, memory = _seconds(stencil, (_SIDE, _SIDE), 40)
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
    step, cache, memory = _seconds(stencil, (64, 64, 64), 40)
    report(
        f"{name} 2 bands, 64³, float32: {step * 1e6:.0f} µs an iteration = "
        f"{step / memory:.2f} x main memory limit, {step / cache:.2f} x traffic of the same arrays"
    )
    assert step <= _ALLOWED_3D[name] * max(memory, cache)


def _seconds(stencil: Stencil, shape: tuple[int, ...], repeats: int) -> tuple[float, float, float]:
    """Of one iteration, of its traffic alone, and of that in main memory."""
    layout = Layout(shape, stencil.basis.size, np.dtype(np.float32))
    source, target, total = (layout.allocate() for _ in range(3))
    layout.view(source)[...] = np.random.default_rng(1).random(layout.view(source).shape)
    sweep = Sweep(stencil, layout)
    step = best_seconds(lambda: sweep.steps(source, target, total, _BATCH), repeats) / _BATCH
    traffic = 4 * stencil.basis.size * np.prod(shape) * 4
    return step, traffic_seconds(layout), traffic / main_memory_bandwidth()
