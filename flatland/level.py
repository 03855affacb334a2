"""One grid of a run: its light, the walls on it, and its books."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from flatland.devices import PROCESSOR, Device
from flatland.errors import SchemeWarning
from flatland.folded_light import FoldedLight
from flatland.grid import Grid
from flatland.kernels import Layout
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.box import cell_count
from flatland.kernels.reports import Buffer
from flatland.ledger import Bookkeeper, Ledger
from flatland.level_sweeps import LevelSweeps
from flatland.light_state import LightState
from flatland.medium import Medium
from flatland.medium_step import MediumStep, in_medium
from flatland.occlusion import Occlusion
from flatland.patch import Patch
from flatland.solvers import SolveReport
from flatland.stencil import Stencil

Values = NDArray[np.floating]

PRECISIONS = ("float64", "float32")
#: Part of a grid's cells that light may begin in for steps in boxes to be compiled ahead.
_SMALL_PART = 16
_CLAMPED = "a clamped step is not linear: the converged field is that of the scheme without clamp"


class Level:
    """One grid that a stencil steps, for light of one or several spectra.

    scales: per spectrum, the power of two that its numbers are kept in units of. occlusion: what
    walls do to the links of this grid; see `block`. skip: cells that light has not reached are not
    swept, nor those that are the mirror image of others, which changes nothing but rounding.
    medium: what fills the grid; the stencil is given as it is without. drop: see `LightState`.
    device: where fields live. Starts dark. Raises InputError for what a medium does not allow.
    """

    def __init__(
        self,
        grid: Grid,
        stencil: Stencil,
        precision: str,
        scales: Sequence[float],
        occlusion: Occlusion,
        skip: bool = True,
        medium: Medium | None = None,
        drop: float = 0.0,
        device: Device = PROCESSOR,
    ) -> None:
        #: What a step does in the medium, if there is one; the stencil is that of the step.
        self.medium: MediumStep | None = None
        if medium is not None:
            self.medium = in_medium(stencil, medium, grid)
        self.grid, self.stencil = grid, stencil if self.medium is None else self.medium.stencil
        self.layout = Layout(grid.shape, stencil.basis.size, np.dtype(precision))
        self.device = device
        scatters = medium is not None
        self.light = FoldedLight(self.layout, self.stencil, scales, skip, drop, scatters, device)
        self.block(occlusion)
        self.reset()

    @property
    def states(self) -> list[LightState]:
        """The light of each spectrum, as far as it is stepped: half of it may be enough."""
        return self.light.states

    def rescale(self, scales: Sequence[float]) -> None:
        """Room for light of other spectra; nothing is lit. Walls stay as they are."""
        self.light.rescale(scales)
        self.reset()

    def block(self, occlusion: Occlusion) -> None:
        """Other walls from now on; the light stays where it is."""
        if self.medium is not None:
            self.medium.require_walls(occlusion)
        self.occlusion = occlusion
        self.light.block(occlusion)
        for name in ("_books", "_steps"):
            self.__dict__.pop(name, None)

    @cached_property
    def _books(self) -> Bookkeeper:
        takes = self.occlusion.transmittance is not None or self.medium is not None
        return Bookkeeper(self.stencil, blocked=takes)

    @cached_property
    def _steps(self) -> LevelSweeps:
        occlusion = self.occlusion
        if self.medium is not None:
            occlusion = self.medium.occlusion(occlusion, self.grid.shape)
        make = partial(self.device.sweep, self.stencil)
        return LevelSweeps(make, self.layout, occlusion, self._books.components)

    @property
    def _sweeps(self) -> list[AnySweep]:
        """The sweep of each spectrum; compiled when light is first here."""
        return self._steps.usual(self.light.fold, len(self.states))

    @property
    def free_first_step(self) -> bool:
        """Whether the first step is not blocked; light that has moved before has had its own."""
        return self.occlusion.free_first_step and not self._moved

    @property
    def _first_sweep(self) -> AnySweep | None:
        """The sweep of the next step, where it is another one than usual."""
        first = self.iteration == 0 and self.free_first_step
        return self._steps.free(self.light.fold) if first else None

    def prepare(self, light: Sequence[Patch] | None = None) -> None:
        """Compile now what stepping needs, so that it is not timed.

        light: per spectrum, what will be started with, in any unit; without it, what is here.
        """
        fold = self.light.fold
        if light is not None:
            fold = self.light.fold_of(light)
        elif not self.dark:
            fold = self.light.fold_now(self._has_moved)
        self._steps.usual(fold, len(self.states))
        self._steps.free(fold)

    @property
    def _has_moved(self) -> bool:
        """Whether there is light that is not where it began."""
        return self._moved or self.iteration > 0

    def reset(self) -> None:
        """No light anywhere, iteration 0, empty books."""
        self.light.reset()
        self.iteration = 0
        self.dark = True
        self._moved = False
        #: Whether `solve` was called, whatever came of it.
        self.solved = False
        self._ledgers = [Ledger() for _ in self.states]
        self._passed: Sequence[Values] | None = None

    def start(self, newest: Sequence[Patch], passed: Sequence[Values] | None = None) -> None:
        """Begin with light per spectrum, in units of its scale.

        passed: light that has been here before; it is part of what is accumulated.
        """
        self.reset()
        self.dark, self._moved = False, passed is not None
        self._passed = passed
        components = list(self._books.components)
        for i, (state, ledger) in enumerate(zip(self.states, self._ledgers)):
            state.start(newest[i], None if passed is None else passed[i], components)
            self._books.open(ledger, float(state.component_sums[0]) * self._unit(state))
        self._prepare_boxes()

    def _prepare_boxes(self) -> None:
        """Compile steps for boxes ahead, where light begins in a small part of the grid."""
        lit = [state.lit for state in self.states]
        if sum(map(cell_count, lit)) * _SMALL_PART < self.grid.cell_count:
            fold = self.light.fold_now(self._has_moved)
            for box, sweep in zip(lit, self._steps.usual(fold, len(lit))):
                sweep.prepare(fold.half_box(box))

    def lit_cells(self) -> NDArray[np.bool_]:
        """Cells that any light has been in, (*shape), by the light itself."""
        lit = [(cells != 0).any(axis=0) for cells in self.cells("total")]
        return np.asarray(np.any(lit, axis=0))

    @property
    def batch(self) -> int:
        """Steps that may run before the next look; no limit where there is no light."""
        if self.dark:
            return 1 << 30
        if self.iteration == 0 and self.free_first_step:
            return 1
        return min(state.batch for state in self.states)

    def advance(self, count: int) -> None:
        """`count` steps, at most `batch`; without light nothing happens."""
        if not self.dark:
            self.light.settle(self._has_moved)
            first = self._first_sweep
            for state, sweep, ledger in zip(self.states, self._sweeps, self._ledgers):
                self._books.drop(ledger, state.trim() * self._unit(state))
                before = state.component_sums
                sums = state.advance(count, first or sweep)
                self._books.enter(ledger, before, sums, self._unit(state), first is None)
        self.iteration += count

    def run(self, count: int) -> None:
        """Any number of steps. Raises InstabilityError when the light grows wild in them."""
        last = self.iteration + count
        while self.iteration < last:
            self.require_tame()
            self.advance(min(last - self.iteration, self.batch))
        if count > 0:
            self.require_tame()

    @property
    def tame(self) -> bool:
        """Whether light has not grown wild."""
        return self.dark or all(state.tame for state in self.states)

    def require_tame(self) -> None:
        """Raise InstabilityError once light has grown wild, so that it never overflows."""
        for state in () if self.dark else self.states:
            state.require_tame(self.iteration)

    def solve(self, tolerance: float, method: str) -> SolveReport | None:
        """Replace the light that was started with by all that ever comes of it.

        See `Simulation.solve`. None if nothing has ever been started.
        """
        self.solved = True
        if self.dark:
            return None
        self.light.unfold()
        reports = [
            self._solve_one(state, sweep, ledger, tolerance, method)
            for state, sweep, ledger in zip(self.states, self._sweeps, self._ledgers)
        ]
        return max(reports, key=lambda report: report.residual)

    def warn_of_clamp(self, stacklevel: int) -> None:
        """Say that a converged field is that of the scheme's linear twin, where it is."""
        if self.stencil.clamp:
            warnings.warn(_CLAMPED, SchemeWarning, stacklevel=stacklevel + 1)

    def _solve_one(
        self, state: LightState, sweep: AnySweep, ledger: Ledger, tolerance: float, method: str
    ) -> SolveReport:
        """Solve for one spectrum and book what its field sends, loses and keeps."""
        clamp = self.stencil.clamp
        sweep = sweep.linear() if clamp else sweep
        # What does not move any more: light that passed before, and what a free first step leaves.
        start: Buffer = state.total - state.target
        free = self._first_sweep
        if free is not None:
            start = state.total.copy()
            before = state.component_sums
            sums = state.advance(1, free.linear() if clamp else free)
            self._books.enter(ledger, before, sums, self._unit(state), blocked=False)
        state.lend()
        try:
            report = self.device.solve(sweep, state.target, state.total, tolerance, method)
            scratch = np.zeros_like(state.total)
            sums = sweep.steps(state.total, state.source, scratch, 1)
            total = state.sums_of(state.total, list(self._books.components))
            self._books.close(ledger, total, sums, self._unit(state))
        finally:
            state.total += start
        state.source[:] = 0
        state.target[:] = 0
        return report

    @property
    def ledgers(self) -> list[Ledger]:
        """Where the flux of each spectrum went; what the medium took apart from what walls took."""
        if self.medium is None or self.dark:
            return self._ledgers
        return [
            self.medium.book(ledger, self._sent(number), self.occlusion)
            for number, ledger in enumerate(self._ledgers)
        ]

    def _sent(self, number: int) -> NDArray[np.float64]:
        """All light (size, *shape) of a spectrum that has left its cell here, summed."""
        state = self.states[number]
        sent = np.asarray(state.cells(state.total), float) - state.cells(state.target)
        if self._passed is not None:
            sent -= self._passed[number]
        return sent * state.scale

    def cells(self, name: str) -> list[Values]:
        """Cells (size, *shape) of "source", "target" or "total" per spectrum, in units of `scale`.

        To be read only, before the run goes on.
        """
        return [state.cells(getattr(state, name)) for state in self.states]

    def values(self, name: str) -> list[Values]:
        """Cells (size, *shape) of "source", "target" or "total" per spectrum, as light really is.

        Not views: they stay when the run goes on.
        """
        return [state.values(getattr(state, name)) for state in self.states]

    def _unit(self, state: LightState) -> float:
        """Flux of one unit of a state's coefficient 0."""
        return float(state.scale * self.stencil.basis.flux_weight)
