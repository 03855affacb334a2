"""Where fields live and are stepped: this machine's own memory and processors, or a device's."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.kernels import Layout, Sweep
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.reports import Buffer
from flatland.light_state import LightState
from flatland.solvers import SolveReport, solve_converged
from flatland.stencil import Stencil

DEVICES = ("cpu", "cuda")


class Device(Protocol):
    """What a level needs of the place where its light is stepped."""

    name: str

    def state(self, layout: Layout, scale: float, skip: bool, drop: float) -> LightState:
        """Light that is dark."""

    def sweep(
        self,
        stencil: Stencil,
        layout: Layout,
        transmittance: NDArray[np.float64] | None,
        sums: tuple[int, ...],
    ) -> AnySweep:
        """What steps it, compiled."""

    def solve(
        self, sweep: AnySweep, right: Buffer, answer: Buffer, tolerance: float, method: str
    ) -> SolveReport:
        """See `solve_converged`; buffers are this machine's."""


class Processor:
    """This machine's own memory and processors."""

    name = "cpu"

    def state(self, layout: Layout, scale: float, skip: bool, drop: float) -> LightState:
        return LightState(layout, scale, skip, drop)

    def sweep(
        self,
        stencil: Stencil,
        layout: Layout,
        transmittance: NDArray[np.float64] | None,
        sums: tuple[int, ...],
    ) -> Sweep:
        return Sweep(stencil, layout, transmittance, sums)

    def solve(
        self, sweep: AnySweep, right: Buffer, answer: Buffer, tolerance: float, method: str
    ) -> SolveReport:
        assert isinstance(sweep, Sweep)
        return solve_converged(sweep, right, answer, tolerance, method)


PROCESSOR = Processor()


def find_device(name: str) -> Device:
    """A device, "cpu" or "cuda". Raises InputError with the reason if it is not there."""
    if name not in DEVICES:
        raise bad_input("device", name, "is unknown", DEVICES)
    if name == "cpu":
        return PROCESSOR
    from flatland.cuda import find_cuda  # looks for CuPy, which takes seconds to load

    return find_cuda()
