"""Whole sets of sweeps, shared among threads."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics
from flatland.kernels.threads import rows_of, run_shared, thread_count
from propagators.sn.nodal import sweep_nodes
from propagators.sn.volumes import DIAMOND, STEP, STEP_CHARACTERISTICS, Tally, sweep_volumes
from propagators.transport.cell_items import CellItems, items_in_cells
from propagators.transport.ordinates import Ordinates
from propagators.transport.problem import DirectProblem

Array = NDArray[np.float64]

_VOLUME_RULES = {"step": STEP, "diamond": DIAMOND, "step-characteristics": STEP_CHARACTERISTICS}
RULES = (*_VOLUME_RULES, "nodal")
#: Waking another thread costs as much as about this many cells times ordinates.
_FEW = 10_000


@dataclass(frozen=True, eq=False)
class Sweeps:
    """One rule and one set of ordinates on one scene."""

    problem: DirectProblem
    rule: str
    ordinates: Ordinates
    lights_block: bool

    @cached_property
    def _items(self) -> CellItems:
        return items_in_cells(self.problem.surfaces.segments, self.problem.shape)

    @cached_property
    def _blocks(self) -> NDArray[np.bool_]:
        """Which elements (E,) stop light: walls, also where a light lies on them."""
        if self.lights_block:
            return np.ones(self.problem.surfaces.count, bool)
        surfaces = self.problem.surfaces
        return surfaces.arrangement.owners[surfaces.owners] >= len(self.problem.geometry.emitters)

    @cached_property
    def _scale(self) -> Array:
        """Factor (E, 1, 1) that makes emission exact in sum."""
        surfaces = self.problem.surfaces
        scale = self.ordinates.emission_scale(surfaces.arrangement.segments)
        return np.asarray(scale[surfaces.owners][:, None, None])

    def run(self, sent: Array, basis: CircularHarmonics | None, lights: bool = True) -> Tally:
        """Sweep all ordinates.

        sent: (E, 2, C), flux that walls send back. basis: None for no cells. lights: whether they
        shine too.
        """
        surfaces = self.problem.surfaces
        radiance = sent / (2 * surfaces.lengths[:, None, None])
        if lights:
            radiance = radiance + surfaces.radiance
        radiance = radiance * self._scale
        directions = self.ordinates.directions
        harmonics = np.empty((len(directions), 0))
        if basis is not None:
            harmonics = self.ordinates.harmonics(basis)
        tallies = [self._tally(sent.shape, harmonics.shape[1]) for _ in range(self._parties())]

        def sweep(party: int, parties: int) -> None:
            mine = slice(*rows_of(party, parties, len(directions)))
            places = directions[mine], harmonics[mine], self.ordinates.weight
            what = self._items, self._blocks, radiance, tallies[party]
            if self.rule == "nodal":
                sweep_nodes(*places, *what)
            else:
                sweep_volumes(_VOLUME_RULES[self.rule], *places, *what)

        run_shared(sweep, len(tallies))
        for other in tallies[1:]:
            for mine, theirs in zip(tallies[0], other):
                mine += theirs
        return tallies[0]

    def _parties(self) -> int:
        nx, ny = self.problem.shape
        return thread_count() if nx * ny * self.ordinates.count > _FEW else 1

    def _tally(self, shape: tuple[int, ...], size: int) -> Tally:
        cells = np.zeros((*self.problem.shape, shape[2] * size))
        return Tally(cells, np.zeros(shape), np.zeros(shape[2]))
