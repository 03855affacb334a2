"""How long a step takes, and how long its memory traffic alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from flatland.harmonics import basis_for
from flatland.kernels import Layout, Sweep
from flatland.stencil import Stencil
from propagators import StencilPropagator, find, names
from studies.bench.limits import best_seconds, main_memory_bandwidth, traffic_seconds

#: Steps in a row per call, as the simulation does them.
_BATCH = 16


@dataclass(frozen=True)
class StepTimes:
    """Seconds of one iteration, and the same memory traffic without arithmetic.

    step: sweep, accumulation, ledger and norm. same_arrays: traffic on arrays of the same size,
    in the cache where the step's are. main_memory: the same number of bytes at the speed of arrays
    that no cache holds.
    """

    step: float
    same_arrays: float
    main_memory: float


def step_seconds(
    stencil: Stencil, shape: tuple[int, ...], precision: str = "float32", repeats: int = 20
) -> StepTimes:
    """Best times of a stencil on a grid without walls, all threads (FLATLAND_THREADS)."""
    layout = Layout(shape, stencil.basis.size, np.dtype(precision))
    source, target, total = (layout.allocate() for _ in range(3))
    layout.view(source)[...] = np.random.default_rng(1).random(layout.view(source).shape)
    sweep = Sweep(stencil, layout)
    step = best_seconds(lambda: sweep.steps(source, target, total, _BATCH), repeats) / _BATCH
    traffic = 4 * stencil.basis.size * float(np.prod(shape)) * layout.dtype.itemsize
    return StepTimes(step, traffic_seconds(layout), traffic / _bandwidth())


def bench_rows(
    schemes: Sequence[str],
    sizes: Mapping[int, Sequence[int]],
    bands: Sequence[int],
    precision: str,
) -> Iterator[dict[str, Any]]:
    """One row per scheme, dimension, size and number of bands.

    schemes: names; all stencil schemes if empty. sizes: cells along each side, by dimension.
    """
    for name in schemes or stencil_names():
        scheme = find(name)()
        for dimension in scheme.dimensions:
            for side in sizes.get(dimension, ()):
                for count in bands:
                    assert isinstance(scheme, StencilPropagator)
                    stencil = scheme.stencil(basis_for(dimension, count))
                    yield _row(name, stencil, side, precision)


def stencil_names() -> list[str]:
    """Every scheme that steps."""
    return [name for name in names() if issubclass(find(name), StencilPropagator)]


def _row(name: str, stencil: Stencil, side: int, precision: str) -> dict[str, Any]:
    dimension = stencil.basis.dimension
    times = step_seconds(stencil, (side,) * dimension, precision)
    return {
        "scheme": name,
        "dimension": dimension,
        "side": side,
        "bands": stencil.basis.bands,
        "precision": precision,
        "seconds": times.step,
        "nanoseconds_per_cell": 1e9 * times.step / side**dimension,
        "over_main_memory": times.step / times.main_memory,
        "over_same_arrays": times.step / times.same_arrays,
    }


@cache
def _bandwidth() -> float:
    return main_memory_bandwidth()
