"""What a run looks like at one iteration: values that no later step changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from flatland.ledger import Ledger
from flatland.simulation import Simulation
from flatland.solvers import SolveReport
from gui.models.levels import count_of, level_fields, merged_fields

#: The grids of a run that can be looked at, with what they hold.
GRIDS = {
    "source": "light one iteration before",
    "target": "newest light",
    "accumulated": "sum of all iterations",
}


@dataclass(frozen=True, eq=False)
class Frame:
    """Fields of a run, copied, so that the worker may step on while they are drawn.

    fields: by the names of GRIDS; a method that does not step has `accumulated` alone. Of an octree
    they are merged, `levels` holds those of each level, and index (*shape) the level that each
    cell is read from.
    unstable_at: the iteration at which light had grown wild, or None.
    """

    fields: dict[str, Field]
    iteration: int = 0
    ledger: Ledger | None = None
    converged: SolveReport | None = None
    seconds_per_step: float = float("nan")
    unstable_at: int | None = None
    levels: tuple[dict[str, Field], ...] = ()
    index: NDArray[np.integer] | None = None

    @property
    def accumulated(self) -> Field:
        return self.fields["accumulated"]

    @property
    def nbytes(self) -> int:
        return sum(field.values.nbytes for field in self.fields.values())


def frame_of(
    simulation: Simulation, seconds_per_step: float = float("nan"), unstable_at: int | None = None
) -> Frame:
    """The state of a simulation as a frame."""
    levels: tuple[dict[str, Field], ...] = ()
    index = None
    if count_of(simulation) > 1:
        fields, levels = merged_fields(simulation, None), level_fields(simulation)
        index = getattr(simulation, "index", None)
    else:
        fields = {name: _own(getattr(simulation, name)) for name in GRIDS}
    return Frame(
        fields,
        simulation.iteration,
        simulation.ledger,
        simulation.converged,
        seconds_per_step,
        unstable_at,
        levels,
        index,
    )


def _own(field: Field) -> Field:
    """A field with memory of its own."""
    values = np.ascontiguousarray(field.values)
    return Field(field.grid, field.basis, values if values.base is None else values.copy())


def flux_balance(ledger: Ledger) -> dict[str, float]:
    """Entries of the ledger [W], colours added up."""
    return {name: float(np.sum(value)) for name, value in ledger.as_dict().items()}
