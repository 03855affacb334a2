"""The flux ledger: where every watt went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.reports import StepSums
from flatland.stencil import Stencil

Flux = NDArray[np.float64]


def _zero() -> Flux:
    return np.zeros(())


@dataclass(eq=False)
class Ledger:
    """Flux [W] since injection, () or (colours,).

    emitted + created = left + absorbed + medium + dropped + inside.

    emitted: injected into cells. left: went out over the grid's border. absorbed: stopped by
    occluders and kept by them. inside: newest light, still to move. created: what the scheme
    itself adds (or, when negative, loses) on the way: zero for a conserving scheme, and the reason
    to look at a clamped or amplified one. reflected: stopped by occluders and sent back, every
    time anew; it is on its way again and no part of the balance. medium: absorbed by what fills
    the grid. dropped: too little to be stepped on, see `Simulation`.
    """

    emitted: Flux = field(default_factory=_zero)
    left: Flux = field(default_factory=_zero)
    absorbed: Flux = field(default_factory=_zero)
    inside: Flux = field(default_factory=_zero)
    created: Flux = field(default_factory=_zero)
    reflected: Flux = field(default_factory=_zero)
    medium: Flux = field(default_factory=_zero)
    dropped: Flux = field(default_factory=_zero)

    @property
    def closure(self) -> Flux:
        """What the books miss, income less all the rest: rounding, if they are right."""
        spent = self.left + self.absorbed + self.medium + self.dropped + self.inside
        return self.emitted + self.created - spent

    def as_dict(self) -> dict[str, Flux]:
        """All entries by name, closure included."""
        entries = {item.name: np.asarray(getattr(self, item.name)) for item in fields(self)}
        return {**entries, "closure": np.asarray(self.closure)}

    @classmethod
    def mixed(cls, ledgers: Sequence[Ledger], mixing: Flux) -> Ledger:
        """The books of colours that are mixes (…, P) of P spectra."""
        return cls(
            **{
                item.name: mixing @ np.array([getattr(ledger, item.name) for ledger in ledgers])
                for item in fields(cls)
            }
        )


class Bookkeeper:
    """Turns what a sweep reports into ledger entries.

    Flux sent out of all cells is Σ_k g_k Σ_x S_k(x), with g the stencil's flux gain (1, 0, 0, …
    for a conserving scheme); what was sent has left, was absorbed or has arrived. A clamped step
    sends more than that; the sweep then reports what was sent.
    """

    def __init__(self, stencil: Stencil, blocked: bool) -> None:
        gain = stencil.flux_gain.copy()
        rounding = np.abs(gain - np.eye(gain.size)[0]) < 1e-14
        gain[rounding] = np.eye(gain.size)[0][rounding]
        self.components = (0, *(int(k) for k in np.flatnonzero(gain) if k != 0))
        self._gain = gain[list(self.components)]
        self._blocked = blocked

    def open(self, ledger: Ledger, flux: float) -> None:
        """Start the books with the flux of the lights."""
        ledger.emitted = np.asarray(flux)
        ledger.inside = np.asarray(flux)

    def drop(self, ledger: Ledger, flux: float) -> None:
        """Book light [W] that was taken away."""
        ledger.dropped = ledger.dropped + flux
        ledger.inside = ledger.inside - flux

    def enter(
        self, ledger: Ledger, before: Flux, sums: StepSums, unit: float, blocked: bool = True
    ) -> None:
        """Book steps. before: component sums (K,) of the light they started from.

        unit: flux of one unit of coefficient 0. blocked: False for steps that nothing stops.
        """
        sources = np.concatenate([before[None], sums.components[:-1]])
        self._book(ledger, sources, sums, unit, blocked)
        ledger.inside = np.asarray(sums.components[-1, 0] * unit)

    def close(self, ledger: Ledger, total: Flux, sums: StepSums, unit: float) -> None:
        """Book a converged run from the component sums of S_A and one step from it."""
        self._book(ledger, total[None], sums, unit)
        ledger.inside = np.zeros(())

    def _book(
        self, ledger: Ledger, sources: Flux, sums: StepSums, unit: float, blocked: bool = True
    ) -> None:
        sent = sources @ self._gain if sums.sent is None else sums.sent
        ledger.left = ledger.left + sums.left.sum() * unit
        ledger.created = ledger.created + (sent - sources[:, 0]).sum() * unit
        if self._blocked and blocked:
            # What came back is among the light that arrived.
            kept = sent - sums.left - sums.components[:, 0]
            ledger.absorbed = ledger.absorbed + kept.sum() * unit
        if sums.reflected is not None:
            ledger.reflected = ledger.reflected + sums.reflected.sum() * unit
