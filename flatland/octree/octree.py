"""Levels over one scene: filled, stepped and read together."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from flatland.devices import PROCESSOR, Device
from flatland.errors import SchemeWarning
from flatland.level import Level
from flatland.occlusion import Occlusion, Walls
from flatland.octree.downsampling import halved
from flatland.octree.falloff import step_factors
from flatland.octree.index import Index, level_index
from flatland.octree.merging import Values, blended, merged
from flatland.octree.reach import Goal, Reach
from flatland.octree.rules import LevelRules
from flatland.patch import Patch
from flatland.scene import Scene
from flatland.solvers import SolveReport
from flatland.stencil import Stencil

_NO_WALLS = (
    "occluders block nothing on coarse levels: the geometry has not been downsampled "
    "(downsample_geometry)"
)


class Octree:
    """Levels 0 … l − 1 of one scene, each a grid of its own (the octree thesis 4.2).

    A quadtree in 2D. Every action stands for itself, in any order: `inject` light into level 0,
    `downsample` it to all other levels, `downsample_geometry`, `run` or `solve` every level by
    itself, look at the `index` volume, `merge`. Numbers of level i are in units of level 0's
    cells: the mean over its children, times the level's factor (see LevelRules).

    scales: per spectrum, and device: see Level. Levels that no merge could read are left behind,
    and catch up when somebody looks at them; what is seen is the same either way.
    """

    def __init__(
        self,
        scene: Scene,
        stencil: Stencil,
        precision: str,
        scales: Sequence[float],
        walls: Walls,
        occlusion: Occlusion,
        rules: LevelRules,
        device: Device = PROCESSOR,
    ) -> None:
        self.scene, self.stencil, self.rules, self.walls = scene, stencil, rules, walls
        self.factors = rules.injection_factors()
        #: What multiplies every step of a level.
        self.step_factors = step_factors(stencil, rules.count, rules.falloff)
        stencils = [stencil, *(stencil.scaled(factor) for factor in self.step_factors[1:])]
        blocked = [occlusion] + [Occlusion()] * (rules.count - 1)
        self.levels = [
            Level(
                grid,
                own,
                precision,
                scales,
                walls_there,
                rules.skip,
                scene.medium,
                rules.drop,
                device,
            )
            for grid, own, walls_there in zip(rules.grids(scene.grid), stencils, blocked)
        ]
        self.has_geometry = rules.count == 1 or occlusion.transmittance is None
        self._warned = False
        self.reset()

    @property
    def iteration(self) -> int:
        return self._goal.iteration

    def reset(self) -> None:
        """No light on any level. The geometry stays."""
        for level in self.levels:
            level.reset()
        self._goal = Goal()
        self._downsampled_at = 0
        self._reach: dict[int, Reach] = {}
        for number in range(len(self.levels)):
            self._mark(number)

    def inject(self, patterns: Sequence[Patch]) -> None:
        """Light, one patch per spectrum, into level 0, from a fresh start; others stay dark."""
        self.reset()
        self.levels[0].start(patterns)
        self._mark(0)

    def downsample(self) -> None:
        """Level 0's light as it is now to all other levels.

        What moves next is the mean of the children times the level's factor; what has passed, the
        mean alone, since it compares as it is. After injection nothing has passed yet.
        """
        finest = self.levels[0]
        dimension = finest.grid.dimension
        newest = [np.array(cells) for cells in finest.cells("target")]
        passed = None
        if finest.iteration or finest.solved:
            passed = [all_ - new for all_, new in zip(finest.cells("total"), newest)]
        for number, level in enumerate(self.levels[1:], 1):
            newest = [halved(values, dimension) for values in newest]
            passed = None if passed is None else [halved(values, dimension) for values in passed]
            if not finest.dark:
                factor = level.layout.dtype.type(self.factors[number])
                level.start([Patch.everywhere(factor * values) for values in newest], passed)
                self._mark(number)
        self._downsampled_at = self.iteration

    def downsample_geometry(self) -> None:
        """Walls of all levels but the first, see Walls.occlusion; until then nothing blocks there.

        Where nothing blocks on level 0, nothing does on others.
        """
        if self.levels[0].occlusion.transmittance is not None:
            for number in range(1, len(self.levels)):
                # Steps that are still to be made up were without these walls.
                level = self.level(number)
                level.block(self.walls.occlusion(self.scene, self.stencil, level=number))
                self._mark(number)
        self.has_geometry = True

    # -- propagation ----------------------------------------------------------------------------

    def prepare(self) -> None:
        """Compile now what steps and the index volume need, so that it is not timed."""
        for level in self.levels:
            level.prepare()
        self.index()

    @property
    def batch(self) -> int:
        """Steps that may run before the next look at whether light is tame."""
        return min(level.batch for level in self._running)

    def set_out(self, iterations: int) -> None:
        """Choose the levels that the next `advance`s, so many steps in all, have to move."""
        self._warn_of_geometry()
        needed = self._needed(Goal(self.iteration + iterations))
        self._running = [self.levels[number] for number in needed]
        for number in needed:
            self._catch_up(number)

    def _needed(self, goal: Goal) -> range:
        """Levels that a merge at a goal, or later, can read.

        Where a level has light everywhere, nothing coarser is read, then or ever after.
        """
        if self.rules.skip and len(self.levels) > 1:
            for number in range(len(self.levels)):
                if self._reach[number].complete(goal):
                    return range(number + 1)
        return range(len(self.levels))

    def advance(self, count: int) -> None:
        """`count` steps, at most `batch`, of each level that was chosen."""
        for level in self._running:
            level.advance(count)
        self._goal = Goal(self.iteration + count)

    def require_tame(self) -> None:
        """Raise InstabilityError once light has grown wild."""
        for level in self._running:
            level.require_tame()

    def solve(self, tolerance: float, method: str) -> SolveReport:
        """All that ever comes of the light of each level, see `Simulation.solve`."""
        self._warn_of_geometry()
        self._goal = Goal(0, tolerance, method)
        report = self.levels[0].solve(tolerance, method)
        assert report is not None  # level 0 is dark only before injection
        for number in self._needed(self._goal):
            self._catch_up(number)
        return report

    def level(self, number: int) -> Level:
        """A level, brought to where all others are.

        Raises InstabilityError once if its light grows wild on the way; it stops there.
        """
        self._catch_up(number)
        return self.levels[number]

    def _catch_up(self, number: int) -> None:
        level, goal = self.levels[number], self._goal
        if goal.tolerance is not None:
            if not level.solved:
                level.solve(goal.tolerance, goal.method)
        elif level.tame:  # wild light stays where it was stopped, to be looked at
            level.run(self._own_steps(number, goal) - level.iteration)

    def _own_steps(self, number: int, goal: Goal) -> int:
        """Steps of a level at a goal: coarse ones count from their downsampling."""
        return goal.iteration - (self._downsampled_at if number else 0)

    def _warn_of_geometry(self) -> None:
        lit = any(not level.dark for level in self.levels[1:])
        if lit and not (self.has_geometry or self._warned):
            warnings.warn(_NO_WALLS, SchemeWarning, stacklevel=4)
            self._warned = True

    # -- reading --------------------------------------------------------------------------------

    def index(self) -> Index:
        """The index volume as it is now, (*shape)."""
        if len(self.levels) == 1:
            return np.zeros(self.scene.grid.shape, np.int8)
        reached = [self._reach[number].reached(self._goal) for number in range(len(self.levels))]
        return level_index(reached, self.rules.index)

    def _mark(self, number: int) -> None:
        """Follow a level's light from where it is by now; only several levels need to know."""
        if len(self.levels) > 1:
            level = self.levels[number]
            self._reach[number] = Reach(level, self.iteration, self.rules.patience)

    def merge(self, spectrum: int, name: str, index: Index, blend: float | None) -> Values:
        """One field on level 0's cells, (size, *shape), for one spectrum; see `merging`."""

        def light(number: int) -> Values:
            level = self.level(number)
            state = level.states[spectrum]
            return state.values(getattr(state, name))

        return merged(light, index) if blend is None else blended(light, index, blend)
