"""Going back in a run: the state of a simulation, kept and put back."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatland.simulation import Simulation

#: What changes while a run goes on, by the names that the parts of a simulation give it. All else
#: is fixed when the simulation is made.
_CHANGING = (
    "source",
    "target",
    "total",
    "norm",
    "start_norm",
    "component_sums",
    "iteration",
    "converged",
    "fold",
    "_settled",
    "dark",
    "solved",
    "merged",
    "_ledgers",
    "_injected",
    "lit",
    "_touched",
    "swept",
    "sweepable",
    "_passed",
    "_moved",
    "_goal",
    "_downsampled_at",
    "_seeds",
)


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A simulation at one iteration. nbytes: what it holds in memory."""

    iteration: int
    parts: tuple[dict[str, Any], ...]

    @property
    def nbytes(self) -> int:
        values = [value for part in self.parts for value in part.values()]
        return sum(value.nbytes for value in values if isinstance(value, np.ndarray))


def capture(simulation: Simulation) -> Snapshot:
    """All that `restore` needs to go on from here, bit for bit."""
    parts = tuple(
        {name: copy.deepcopy(value) for name, value in vars(part).items() if name in _CHANGING}
        for part in _parts(simulation)
    )
    return Snapshot(simulation.iteration, parts)


def restore(simulation: Simulation, snapshot: Snapshot) -> None:
    """Back to what `capture` saw in this simulation: what follows is the same, bit for bit.

    What it cannot do: take a snapshot of another simulation.
    """
    for part, kept in zip(_parts(simulation), snapshot.parts, strict=True):
        for name, value in kept.items():
            now = getattr(part, name)
            if isinstance(now, np.ndarray) and name in ("source", "target", "total"):
                now[...] = value  # buffers stay where they are: sweeps may know their place
            else:
                setattr(part, name, copy.deepcopy(value))


def _parts(simulation: Simulation) -> Iterator[Any]:
    """The simulation and all of it that changes.

    One after another: what a level holds depends on how it is folded.
    """
    yield simulation
    octree = getattr(simulation, "octree", None)
    if octree is None:
        yield from simulation._states
        return
    yield octree
    for level in octree.levels:
        yield level
        yield level.light
        yield from level.states
