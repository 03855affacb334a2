"""The state machine that steps light through a grid."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from numbers import Integral
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flatland.errors import SchemeWarning, bad_input
from flatland.field import Field
from flatland.harmonics import AngularBasis, basis_for
from flatland.injection import independent_spectra, inject, most_spectra
from flatland.kernels import Layout, Sweep
from flatland.kernels.reports import Buffer
from flatland.ledger import Bookkeeper, Ledger
from flatland.light_state import LightState
from flatland.medium_step import enter_medium
from flatland.memory import require_memory
from flatland.occlusion import Occlusion, Walls, without_first_bounces
from flatland.scene import Scene
from flatland.solvers import SolveReport, solve_converged
from flatland.stencil import Stencil

PRECISIONS = ("float64", "float32")
_CLAMPED = "a clamped step is not linear: the converged field is that of the scheme without clamp"


class Scheme(Protocol):
    """What a simulation needs of a propagator."""

    def stencil(self, basis: AngularBasis) -> Stencil: ...

    def warn_if_unstable(self, stencil: Stencil) -> None: ...


class Simulation:
    """One scene, one stencil propagator, stepped (numerics §3).

    bands: angular bands. levels: octree levels; this version steps the uniform grid, 1.
    precision: "float64" or "float32". transmittance: (K, *shape), the share of the light leaving
    a cell along each of the stencil's offsets that nothing blocks; if given, the scene's
    occluders have no effect. What they do otherwise:
    blocking: "exact" cuts beams (flatland.blocking.exact), "fuzzy" reads a geometry volume, not in
    the first step (flatland.blocking.fuzzy), "none" lets light pass. strength: of the fuzzy one.
    bounces: what occluders stop comes back by their albedo, step after step; lamps then inject
    their own light only, since its first bounce is one of these. lights_block: area lights are
    black walls for light from elsewhere; they do not cut the links by which their own leaves.

    `target` is the newest light, `source` what it was one step before, `accumulated` the sum of
    all, S_A = Σ_i S_i. Scenes in colour are stepped once per linearly independent spectrum.
    Raises InputError for arguments that break a rule and for a grid that would not fit in memory;
    warns (SchemeWarning) of an unstable scheme.
    """

    def __init__(
        self,
        scene: Scene,
        propagator: Scheme,
        bands: int = 2,
        levels: int = 1,
        precision: str = "float64",
        transmittance: NDArray[np.floating] | None = None,
        blocking: str = "exact",
        strength: float = 1.0,
        bounces: bool = True,
        lights_block: bool = False,
    ) -> None:
        if precision not in PRECISIONS:
            raise bad_input("precision", precision, "is unknown", PRECISIONS)
        if levels != 1:
            raise bad_input("levels", levels, "must be 1: this version steps the uniform grid")
        walls = Walls(blocking, strength, bounces, lights_block)
        self.scene, self.propagator, self.precision = scene, propagator, precision
        self.basis = basis_for(scene.grid.dimension, bands)
        self.stencil = propagator.stencil(self.basis)
        propagator.warn_if_unstable(self.stencil)
        layout = Layout(scene.grid.shape, self.basis.size, np.dtype(precision))
        self._require_room(layout)
        tau = _checked_transmittance(transmittance, self.stencil, scene)
        given = Occlusion(tau)
        self._occlusion = walls.occlusion(scene, self.stencil) if tau is None else given
        self._walls, self._medium = self._occlusion, enter_medium(self.stencil, scene)
        if self._medium is not None:
            self.stencil = self._medium.stencil
            self._occlusion = self._medium.occlusion(self._walls, scene.grid.shape)
        tau = self._occlusion.transmittance
        takes = tau is not None or self._medium is not None
        self._books = Bookkeeper(self.stencil, blocked=takes)
        sweep = Sweep(self.stencil, layout, tau, self._books.components)
        patterns, self._mixing = self._spectra()
        self._states = [
            LightState(layout, each, pattern)
            for each, pattern in zip(self._sweeps(sweep, len(patterns)), patterns)
        ]
        #: For a first step that is not blocked.
        self._free_sweep = (
            Sweep(self.stencil, layout, None, self._books.components)
            if self._occlusion.free_first_step
            else None
        )
        self._require_range()
        self.reset()

    def _require_room(self, layout: Layout) -> None:
        """Refuse a grid whose fields would not fit in memory.

        Three per spectrum, and the pattern of light that it starts from in float64.
        """
        spectra = max(1, self.scene.colours)
        if not self.stencil.clamp:
            spectra = most_spectra(self.scene)
        needed = spectra * layout.size * (3 * layout.dtype.itemsize + 8)
        require_memory(needed, "grid.shape", self.scene.grid.shape)

    def _spectra(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Patterns (P, size, *shape) that are stepped and mixing (colours, P)."""
        lights = without_first_bounces(self.scene) if self._walls.reflections else self.scene
        if not (self.stencil.clamp or self._occlusion.coloured):
            return independent_spectra(lights, self.basis)
        # A clamped step is not linear, and coloured walls treat every colour in their own way:
        # every colour goes alone.
        values = inject(lights, self.basis).values
        values = values if self.scene.colours else values[None]
        return np.asarray(values, float), np.eye(len(values))

    def _sweeps(self, sweep: Sweep, count: int) -> list[Sweep]:
        """The sweep of each pattern."""
        reflections = self._occlusion.reflections
        if self._occlusion.coloured:
            return [sweep.reflecting(reflection) for reflection in reflections]
        return [sweep.reflecting(reflections[0]) if reflections else sweep] * count

    def _require_range(self) -> None:
        """Refuse light that the precision cannot hold, with a million to spare either way."""
        scales = np.array([state.scale for state in self._states])
        size = float((np.abs(self._mixing) * scales).max())
        limits = np.finfo(self.precision)
        if not 1e6 * float(limits.tiny) < size < 1e-6 * float(limits.max):
            rule = f"cannot hold light of about {size:.0e} per unit angle"
            raise bad_input("precision", self.precision, rule, ("float64",))

    def reset(self) -> None:
        """No light anywhere, iteration 0, empty books."""
        for state in self._states:
            state.reset()
        self.iteration = 0
        self.converged: SolveReport | None = None
        self._injected = False
        self._ledgers = [Ledger() for _ in self._states]

    def inject(self) -> None:
        """Put the scene's lights into their cells, from a fresh start."""
        self.reset()
        for state, ledger in zip(self._states, self._ledgers):
            state.inject()
            self._books.open(ledger, float(state.component_sums[0]) * self._unit(state))
        self._injected = True

    def step(self) -> None:
        """One iteration: every cell's light goes to its neighbours."""
        self.run(1)

    def run(self, iterations: int, progress: Callable[[int], object] | None = None) -> None:
        """Several iterations; injects first if that was not done.

        progress: called with the number of iterations just done; runs between batches.
        Raises InstabilityError when the light grows wild; the state before overflow is kept.
        """
        if not isinstance(iterations, Integral) or isinstance(iterations, bool) or iterations < 0:
            raise bad_input("iterations", iterations, "must be a whole number, at least 0")
        self._start()
        last = self.iteration + int(iterations)
        while self.iteration < last:
            self._require_tame()
            count = min(last - self.iteration, *(state.batch for state in self._states))
            first = self._free_sweep if self.iteration == 0 else None
            if first is not None:
                count = 1
            for state, ledger in zip(self._states, self._ledgers):
                before = state.component_sums
                sums = state.advance(count, first)
                self._books.enter(ledger, before, sums, self._unit(state), first is None)
            self.iteration += count
            if progress is not None:
                progress(count)
        self._require_tame()

    def _require_tame(self) -> None:
        """Raise InstabilityError once light has grown wild, so that it never overflows."""
        for state in self._states:
            state.require_tame(self.iteration)

    def solve(self, tolerance: float = 1e-8, method: str = "auto") -> SolveReport:
        """Jump to the converged field (1 − A) S_A = S_0; the books are closed with it.

        A contains what comes back from walls. If the first step is free of blocking, by A_free, it
        is done first: S_A = S_0 + (1 − A)⁻¹ A_free S_0.

        tolerance: relative residual ‖S_0 − (1 − A) S_A‖ / ‖S_0‖. method: see `solve_converged`.
        For a clamped scheme this is the answer of its linear twin. Raises ConvergenceError if the
        tolerance was not reached, InstabilityError if the scheme's radius says there is no answer.
        """
        self.inject()
        self._injected = False  # also if this fails, stepping starts afresh
        if self.stencil.clamp:
            warnings.warn(_CLAMPED, SchemeWarning, stacklevel=2)
        states = zip(self._states, self._ledgers)
        reports = [self._solve_one(*each, tolerance, method) for each in states]
        self.converged = max(reports, key=lambda report: report.residual)
        return self.converged

    def _solve_one(
        self, state: LightState, ledger: Ledger, tolerance: float, method: str
    ) -> SolveReport:
        """Solve for one pattern and book what its field sends, loses and keeps."""
        clamp = self.stencil.clamp
        sweep = state.sweep.linear() if clamp else state.sweep
        start: Buffer | float = 0.0
        if self._free_sweep is not None:
            start = state.total.copy()
            before = state.component_sums
            sums = state.advance(1, self._free_sweep.linear() if clamp else self._free_sweep)
            self._books.enter(ledger, before, sums, self._unit(state), blocked=False)
        try:
            report = solve_converged(sweep, state.target, state.total, tolerance, method)
            scratch = np.zeros_like(state.total)
            sums = sweep.steps(state.total, state.source, scratch, 1)
            self._books.close(ledger, state.sums_of(state.total), sums, self._unit(state))
        finally:
            state.total += start
        state.source[:] = 0
        state.target[:] = 0
        return report

    def _start(self) -> None:
        if self.converged is not None or not self._injected:
            self.inject()

    # -- what can be looked at ------------------------------------------------------------------

    @property
    def source(self) -> Field:
        return self._field([state.values(state.source) for state in self._states])

    @property
    def target(self) -> Field:
        return self._field([state.values(state.target) for state in self._states])

    @property
    def accumulated(self) -> Field:
        return self._field([state.values(state.total) for state in self._states])

    @property
    def ledger(self) -> Ledger:
        """Where the flux went, () or (colours,)."""
        mixing = self._mixing if self.scene.colours else self._mixing[0]
        return Ledger.mixed([self._parted(*each) for each in enumerate(self._ledgers)], mixing)

    def _parted(self, number: int, ledger: Ledger) -> Ledger:
        """The books of one pattern, with what a medium takes apart from what walls take."""
        if self._medium is None:
            return ledger
        state = self._states[number]
        sent = state.values(state.total) - state.values(state.target)
        return self._medium.book(ledger, np.asarray(sent, float), self._walls)

    def _field(self, values: list[NDArray[np.floating]]) -> Field:
        if self.scene.colours:
            mixing = self._mixing.astype(self.precision)
            return Field(self.scene.grid, self.basis, np.tensordot(mixing, np.array(values), 1))
        factor = self._mixing[0, 0]
        mono = values[0] if factor == 1.0 else values[0] * factor
        return Field(self.scene.grid, self.basis, mono)

    def _unit(self, state: LightState) -> float:
        """Flux of one unit of a state's coefficient 0."""
        return float(state.scale * self.basis.flux_weight)


def _checked_transmittance(
    values: NDArray[np.floating] | None, stencil: Stencil, scene: Scene
) -> NDArray[np.float64] | None:
    if values is None:
        return None
    expected = (len(stencil.offsets), *scene.grid.shape)
    array = np.asarray(values, float)
    if array.shape != expected:
        raise bad_input("transmittance", array.shape, f"must be of shape {expected}")
    if not np.all((array >= 0) & (array <= 1)):
        raise bad_input("transmittance", values, "must lie between 0 and 1")
    return array
