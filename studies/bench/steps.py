"""How long a step takes, and how long its memory traffic alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import basis_for
from flatland.kernels import Layout, Sweep
from flatland.kernels.arrivals import written_operations
from flatland.stencil import Stencil
from propagators import StencilPropagator, find, names
from studies.bench.limits import (
    Traffic,
    best_seconds,
    main_memory_bandwidth,
    multiply_add_rate,
)

#: Steps in a row per call, as the simulation does them.
_BATCH = 8


@dataclass(frozen=True)
class StepTimes:
    """Seconds of one iteration, and of parts of it that no iteration can do without.

    step: sweep, accumulation, ledger and norm. same_arrays: the traffic of source, target and total
    alone, on arrays of the same size, in the cache where the step's are. main_memory: the same
    number of bytes at the speed of arrays that no cache holds. arithmetic: the additions and
    multiply-adds of the sweep as it is written out, from registers.
    """

    step: float
    same_arrays: float
    main_memory: float
    arithmetic: float

    @property
    def limit(self) -> float:
        """The largest of them."""
        return max(self.same_arrays, self.main_memory, self.arithmetic)


def step_seconds(
    stencil: Stencil,
    shape: tuple[int, ...],
    precision: str = "float32",
    repeats: int = 20,
    transmittance: NDArray[np.float64] | None = None,
) -> StepTimes:
    """Best times of a stencil on a grid, all threads (FLATLAND_THREADS).

    Steps and traffic take turns, so that both meet the same moods of the machine. transmittance: of
    walls, if there are any; its traffic and arithmetic are in no limit.
    """
    layout = Layout(shape, stencil.basis.size, np.dtype(precision))
    source, target, total = (layout.allocate() for _ in range(3))
    layout.view(source)[...] = np.random.default_rng(1).random(layout.view(source).shape)
    sweep, traffic = Sweep(stencil, layout, transmittance), Traffic(layout)
    cells = float(np.prod(shape))
    bytes_moved = 4 * stencil.basis.size * cells * layout.dtype.itemsize
    step = same = math.inf
    for _ in range(repeats):
        step = min(step, best_seconds(lambda: sweep.steps(source, target, total, _BATCH), 1))
        same = min(same, traffic.seconds(1))
        total[:] = 0
    operations = written_operations(stencil) * cells
    return StepTimes(
        step / _BATCH,
        same,
        bytes_moved / main_memory_bandwidth(),
        operations / multiply_add_rate(precision),
    )


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
        "over_arithmetic": times.step / times.arithmetic,
        "over_limit": times.step / times.limit,
    }
