"""A full iteration (step, accumulate, ledger, norm) against its memory traffic and arithmetic."""

from __future__ import annotations

import numpy as np
import pytest

import propagators
from flatland.blocking import exact_transmittance
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.sources import Facet, Segment
from studies.bench.limits import best_seconds, numpy_step
from studies.bench.steps import StepTimes, step_seconds

_SHAPE = {2: (512, 512), 3: (64, 64, 64)}
#: Largest allowed ratio to the larger of traffic and arithmetic, by dimension and bands; walls may
#: make it half as much again.
_ALLOWED = {
    **{(2, bands): 1.5 for bands in (2, 3)},
    (2, 5): 2.5,
    (3, 2): 2.0,
    **{(3, bands): 3.0 for bands in (3, 4, 5)},
}
_FOR_WALLS = 1.5
#: The same of space and 2 bands to the traffic alone.
_ALLOWED_TRAFFIC = 3.0
_SCHEMES = {2: ("lpv", "lpv-2009", "dom4", "dom8"), 3: ("lpv", "lpv-2009", "dom6", "dom26")}
_ROWS = [(name, *place) for place in _ALLOWED for name in _SCHEMES[place[0]]]


def _row(name: str, dimension: int, bands: int, times: StepTimes, walls: str) -> str:
    parts = {
        "main memory": times.main_memory,
        "same arrays": times.same_arrays,
        "arithmetic": times.arithmetic,
    }
    ratios = ", ".join(f"{times.step / part:.2f} x {word}" for word, part in parts.items())
    side = f"{_SHAPE[dimension][0]}{'²' if dimension == 2 else '³'}"
    return (
        f"{name} {bands} bands, {side}, float32{walls}: {times.step * 1e6:.0f} µs = {ratios}; "
        f"{times.step / times.limit:.2f} x the limit"
    )


def _transmittance(dimension: int, offsets: np.ndarray) -> np.ndarray:
    """Of 20 walls across the grid, each a quarter of its side long."""
    generator, side = np.random.default_rng(0), _SHAPE[dimension][0]
    ends = side * generator.random((20, 2, dimension))
    ends[:, 1] = ends[:, 0] + (ends[:, 1] - ends[:, 0]) / 2
    grid, black = Grid(_SHAPE[dimension]), np.zeros(1)
    if dimension == 2:
        return exact_transmittance(grid, [Segment(a, b, black) for a, b in ends], offsets)
    along = side / 4 * np.eye(3)
    facets = [
        Facet(a + np.array([0 * u, u, u + v, v]), black)
        for i, (a, _) in enumerate(ends)
        for u, v in [(along[i % 3], along[(i + 1) % 3])]
    ]
    return exact_transmittance(grid, facets, offsets)


@pytest.mark.parametrize(("name", "dimension", "bands"), _ROWS)
def test_iteration_is_near_the_limit(name, dimension, bands, report):
    stencil = propagators.create(name).stencil(basis_for(dimension, bands))
    times = step_seconds(stencil, _SHAPE[dimension], repeats=25)
    report(_row(name, dimension, bands, times, ""))
    assert times.step <= _ALLOWED[dimension, bands] * times.limit
    if (dimension, bands) == (3, 2):
        assert times.step <= _ALLOWED_TRAFFIC * max(times.main_memory, times.same_arrays)


@pytest.mark.parametrize(("name", "dimension", "bands"), _ROWS)
def test_iteration_with_walls_is_near_the_limit(name, dimension, bands, report):
    stencil = propagators.create(name).stencil(basis_for(dimension, bands))
    tau = _transmittance(dimension, stencil.offsets)
    times = step_seconds(stencil, _SHAPE[dimension], repeats=25, transmittance=tau)
    report(_row(name, dimension, bands, times, ", 20 walls"))
    assert times.step <= _FOR_WALLS * _ALLOWED[dimension, bands] * times.limit


@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8"])
def test_iteration_against_matrix_products(name, report):
    stencil = propagators.create(name).stencil(basis_for(2, 5))
    times = step_seconds(stencil, _SHAPE[2], repeats=10)
    cells = np.random.default_rng(1).random((stencil.basis.size, *_SHAPE[2]), np.float32)
    target, total = np.empty_like(cells), np.zeros_like(cells)
    plain = best_seconds(lambda: numpy_step(stencil, cells, target, total), 5)
    report(f"{name} 5 bands, 512²: NumPy takes {plain / times.step:.0f} x as long")
    assert plain >= 10 * times.step
