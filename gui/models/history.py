"""Back to any earlier iteration: key frames, and stepping from the nearest one."""

from __future__ import annotations

from flatland.simulation import Simulation
from flatland.snapshots import Snapshot, capture, restore

#: Memory that key frames may take.
BUDGET = 256 * 2**20
#: Iterations between two key frames, to begin with.
SPACING = 16


class History:
    """Snapshots of a run at every `spacing`-th iteration.

    When they would take more than `budget` bytes, every second one is dropped and the spacing
    doubles: memory stays bounded, and going back costs at most `spacing` steps. A step of 128 x
    128 cells and 5 bands takes a quarter of a millisecond and a snapshot 3.7 MB, so 1,000
    iterations cost 256 MB at most and any of them is back after at most 16 steps.
    What it cannot do: keep less than two snapshots, however large they are.
    """

    def __init__(self, budget: int = BUDGET, spacing: int = SPACING) -> None:
        self.budget, self.spacing = budget, spacing
        self._keys: dict[int, Snapshot] = {}
        self.clear()

    def clear(self) -> None:
        self._keys.clear()
        self._fixed: set[int] = set()
        #: The latest iteration that was reached.
        self.reached = 0

    @property
    def nbytes(self) -> int:
        return sum(key.nbytes for key in self._keys.values())

    @property
    def key_frames(self) -> list[int]:
        return sorted(self._keys)

    def record(self, simulation: Simulation) -> None:
        """Keep a snapshot if one is due at this iteration."""
        now = simulation.iteration
        self.reached = max(self.reached, now)
        if now % self.spacing or now in self._keys:
            return
        self._keys[now] = capture(simulation)
        while self.nbytes > self.budget and len(self._keys) > 2:
            self.spacing *= 2
            self._keys = {
                i: key for i, key in self._keys.items() if i % self.spacing == 0 or i in self._fixed
            }

    def mark(self, simulation: Simulation) -> None:
        """What is there now was changed by hand: later iterations follow from this."""
        now = simulation.iteration
        self._keys = {i: key for i, key in self._keys.items() if i < now}
        self._keys[now] = capture(simulation)
        self._fixed = {i for i in self._fixed if i < now} | {now}
        self.reached = now

    def passed(self, simulation: Simulation) -> None:
        """After a step: take over what was changed by hand at this iteration."""
        if simulation.iteration in self._fixed:
            restore(simulation, self._keys[simulation.iteration])

    def go_to(self, simulation: Simulation, iteration: int) -> None:
        """Bring the simulation to an iteration that it has reached, exactly as it was.

        Stepped on from where it is if that is nearer than a key frame.
        """
        earlier = [i for i in self._keys if i <= iteration]
        here = simulation.iteration if simulation.converged is None else -1
        start = max(earlier, default=0)
        changed = any(here < i <= iteration for i in self._fixed)
        if changed or not (start <= here <= iteration):
            if earlier:
                restore(simulation, self._keys[start])
            else:
                simulation.inject()
        simulation.run(iteration - simulation.iteration)
