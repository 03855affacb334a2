"""The state machine that steps light through a grid."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from numbers import Integral
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flatland.blocking import exact_transmittance
from flatland.errors import SchemeWarning, bad_input
from flatland.field import Field
from flatland.harmonics import AngularBasis, basis_for
from flatland.injection import independent_spectra, inject
from flatland.kernels import Layout, Sweep
from flatland.ledger import Bookkeeper, Ledger
from flatland.light_state import LightState
from flatland.memory import require_memory
from flatland.scene import Scene
from flatland.solvers import SolveReport, solve_converged
from flatland.stencil import Stencil

PRECISIONS = ("float64", "float32")
BLOCKING = ("exact", "none")
_CLAMPED = "a clamped step is not linear: the converged field is that of the scheme without clamp"


class Scheme(Protocol):
    """What a simulation needs of a propagator."""

    def stencil(self, basis: AngularBasis) -> Stencil: ...

    def warn_if_unstable(self, stencil: Stencil) -> None: ...


class Simulation:
    """One scene, one stencil propagator, stepped (numerics §3).

    bands: angular bands. levels: octree levels; this version steps the uniform grid, 1.
    precision: "float64" or "float32". transmittance: (K, *shape), the share of the light leaving
    a cell along each of the stencil's offsets that nothing blocks; taken from the scene's
    occluders if not given, unless blocking="none", which lets light pass through them.

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
    ) -> None:
        if precision not in PRECISIONS:
            raise bad_input("precision", precision, "is unknown", PRECISIONS)
        if levels != 1:
            raise bad_input("levels", levels, "must be 1: this version steps the uniform grid")
        if blocking not in BLOCKING:
            raise bad_input("blocking", blocking, "is unknown", BLOCKING)
        self.scene, self.propagator, self.precision = scene, propagator, precision
        self.basis = basis_for(scene.grid.dimension, bands)
        self.stencil = propagator.stencil(self.basis)
        propagator.warn_if_unstable(self.stencil)
        layout = Layout(scene.grid.shape, self.basis.size, np.dtype(precision))
        spectra = max(1, scene.colours)
        if not self.stencil.clamp:
            spectra = max(1, min(spectra, len(scene.lights)))
        # Three fields, and the pattern of light that each spectrum starts from in float64.
        needed = spectra * layout.size * (3 * layout.dtype.itemsize + 8)
        require_memory(needed, "grid.shape", scene.grid.shape)
        tau = _checked_transmittance(transmittance, self.stencil, scene)
        if tau is None and blocking == "exact":
            tau = _blocked_by_occluders(scene, self.stencil)
        self._books = Bookkeeper(self.stencil, blocked=tau is not None)
        self._sweep = Sweep(self.stencil, layout, tau, self._books.components)
        patterns, self._mixing = self._spectra()
        self._states = [LightState(layout, self._sweep, pattern) for pattern in patterns]
        self._require_range()
        self.reset()

    def _spectra(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Patterns (P, size, *shape) that are stepped and mixing (colours, P)."""
        if not self.stencil.clamp:
            return independent_spectra(self.scene, self.basis)
        # A clamped step is not linear: every colour goes alone.
        values = inject(self.scene, self.basis).values
        values = values if self.scene.colours else values[None]
        return np.asarray(values, float), np.eye(len(values))

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
            for state, ledger in zip(self._states, self._ledgers):
                before = state.component_sums
                sums = state.advance(count)
                self._books.enter(ledger, before, sums, self._unit(state))
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

        tolerance: relative residual ‖S_0 − (1 − A) S_A‖ / ‖S_0‖. method: see `solve_converged`.
        For a clamped scheme this is the answer of its linear twin. Raises ConvergenceError if the
        tolerance was not reached, InstabilityError if the scheme's radius says there is no answer.
        """
        self.inject()
        self._injected = False  # also if this fails, stepping starts afresh
        sweep = self._sweep
        if self.stencil.clamp:
            warnings.warn(_CLAMPED, SchemeWarning, stacklevel=2)
            sweep = sweep.linear()
        reports = []
        for state, ledger in zip(self._states, self._ledgers):
            report = solve_converged(sweep, state.target, state.total, tolerance, method)
            reports.append(report)
            self._close(sweep, state, ledger)
        self.converged = max(reports, key=lambda report: report.residual)
        return self.converged

    def _close(self, sweep: Sweep, state: LightState, ledger: Ledger) -> None:
        """Book the whole run at once: what S_A sends, loses and keeps."""
        scratch = np.zeros_like(state.total)
        sums = sweep.steps(state.total, state.source, scratch, 1)
        self._books.close(ledger, state.sums_of(state.total), sums, self._unit(state))
        state.source[:] = 0
        state.target[:] = 0

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
        return Ledger.mixed(self._ledgers, mixing)

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


def _blocked_by_occluders(scene: Scene, stencil: Stencil) -> NDArray[np.float64] | None:
    segments = scene.segments()
    return exact_transmittance(scene.grid, segments, stencil.offsets) if segments else None


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
