"""What can be looked at on one level of a simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flatland.field import Field
from flatland.grid import Grid
from flatland.ledger import Ledger

if TYPE_CHECKING:
    from flatland.simulation import Simulation


class LevelView:
    """What can be looked at on one level of a simulation, in units of level 0's cells."""

    def __init__(self, simulation: Simulation, number: int) -> None:
        self._simulation, self._number = simulation, number

    @property
    def grid(self) -> Grid:
        return self._simulation.octree.levels[self._number].grid

    @property
    def source(self) -> Field:
        return self._simulation._level_field(self._number, "source")

    @property
    def target(self) -> Field:
        return self._simulation._level_field(self._number, "target")

    @property
    def accumulated(self) -> Field:
        return self._simulation._level_field(self._number, "accumulated")

    @property
    def ledger(self) -> Ledger:
        """Where the flux of this level went, () or (colours,)."""
        return self._simulation._level_ledger(self._number)
