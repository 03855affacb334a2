"""A scene on nested grids: injected together, propagated apart, looked up as one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.cascades.grids import cascade_grids
from flatland.cascades.lookup import looked_up
from flatland.errors import bad_input
from flatland.field import Field
from flatland.harmonics import basis_for
from flatland.injection import spectra_on
from flatland.kernels import Layout
from flatland.ledger import Ledger
from flatland.level import PRECISIONS, Level
from flatland.light_state import light_scale
from flatland.medium_step import warn_of_spread
from flatland.memory import require_memory
from flatland.occlusion import Walls, without_first_bounces
from flatland.patch import Patch
from flatland.scene import Scene
from flatland.solvers import SolveReport
from flatland.stencil import Scheme

Array = NDArray[np.float64]
#: Cells over which a grid fades into the next coarser one.
FADE = 2.0


class Cascade:
    """One scene on nested grids (Kaplanyan & Dachsbacher 2010, 4; numerics §8).

    levels: grids, finest first, of `cells` along every axis; the finest has the scene's cells, and
    each further one cells twice as large, round `focus` [m], the middle of the scene without it:
    see cascade_grids. All receive all lights and occluders that lie in them; then each steps by
    itself. blocking, strength, bounces, lights_block, precision, bands: as in Simulation.

    Numbers of a level are those of its own cells. A cell of side h has h^{D−1} of the flux of a
    uniform field pass through it, so that level c compares with the finest one times 2^{−c(D−1)};
    look-ups do that. Lights are injected with all their flux: in the octree's words that is 2^c
    times the mean of the children, in units of the finest cells (its "flux" normalization).

    A coarse cell gets what the scene's own cells in it get, so that lights are moved along their
    normal by half a cell of the finest grid, on all of them.

    What it gets wrong: light from outside of a grid does not come in, whatever the coarser grid
    knows; `outside` says how much flux of the lights that is. On coarse grids LPV diffuses less.
    Raises InputError and warns like Simulation.
    """

    def __init__(
        self,
        scene: Scene,
        propagator: Scheme,
        bands: int = 2,
        levels: int = 3,
        cells: int = 32,
        focus: Sequence[float] | None = None,
        precision: str = "float64",
        blocking: str = "exact",
        strength: float = 1.0,
        bounces: bool = True,
        lights_block: bool = False,
    ) -> None:
        if precision not in PRECISIONS:
            raise bad_input("precision", precision, "is unknown", PRECISIONS)
        centre = scene.grid.to_world(np.array(scene.grid.shape) / 2) if focus is None else focus
        self.scene, self.propagator, self.precision = scene, propagator, precision
        self.grids = cascade_grids(scene.grid, levels, cells, tuple(centre))
        self.basis = basis_for(scene.grid.dimension, bands)
        self.stencil = propagator.stencil(self.basis)
        propagator.warn_if_unstable(self.stencil)
        self._require_room()
        walls = Walls(blocking, strength, bounces, lights_block)
        occlusions = [walls.occlusion(scene, self.stencil, grid=grid) for grid in self.grids]
        coloured = any(occlusion.coloured for occlusion in occlusions)
        lights = without_first_bounces(scene) if any(o.reflections for o in occlusions) else scene
        self._patterns, self._mixing, self._outside = spectra_on(
            lights, self.basis, self.grids, apart=coloured or self.stencil.clamp
        )
        self._levels = [
            Level(
                grid,
                self.stencil,
                precision,
                [light_scale(p) for p in patterns],
                occlusion,
                medium=scene.medium,
            )
            for grid, patterns, occlusion in zip(self.grids, self._patterns, occlusions)
        ]
        warn_of_spread([level.medium for level in self._levels])
        self.reset()

    def _require_room(self) -> None:
        size = Layout(self.grids[0].shape, self.basis.size, np.dtype(self.precision)).size
        spectra = max(1, self.scene.colours) * len(self.grids)
        needed = spectra * size * (3 * np.dtype(self.precision).itemsize + 8)
        require_memory(needed, "cells", self.grids[0].shape[0])

    def reset(self) -> None:
        """No light anywhere."""
        for level in self._levels:
            level.reset()
        self.iteration = 0
        self._injected = False

    def inject(self) -> None:
        """All lights into all grids, from a fresh start."""
        self.reset()
        for level, patterns in zip(self._levels, self._patterns):
            light = [
                Patch.around(p) * (1 / state.scale) for p, state in zip(patterns, level.states)
            ]
            level.start(light)
        self._injected = True

    def run(self, iterations: int, progress: Callable[[int], object] | None = None) -> None:
        """So many steps of every grid; injects first if that was not done.

        progress: called with the number of iterations once they are done on all grids. Raises
        InstabilityError when the light grows wild.
        """
        if not isinstance(iterations, Integral) or isinstance(iterations, bool) or iterations < 0:
            raise bad_input("iterations", iterations, "must be a whole number, at least 0")
        if not self._injected:
            self.inject()
        for level in self._levels:
            level.run(int(iterations))
        self.iteration += int(iterations)
        if progress is not None:
            progress(int(iterations))

    def solve(self, tolerance: float = 1e-8, method: str = "auto") -> list[SolveReport]:
        """Jump to the converged field of every grid, see `Simulation.solve`."""
        self.inject()
        self._injected = False
        self._levels[0].warn_of_clamp(2)
        reports = [level.solve(tolerance, method) for level in self._levels]
        return [report for report in reports if report is not None]

    # -- what can be looked at ------------------------------------------------------------------

    def accumulated(self, level: int) -> Field:
        """What has accumulated on one grid, in units of its own cells.

        Raises InputError for a level that is not there.
        """
        self._require_level(level)
        values = np.array(self._levels[level].values("total"))
        return Field(self.grids[level], self.basis, self._mixed(values))

    def ledger(self, level: int) -> Ledger:
        """Where the flux that was injected into one grid went, () or (colours,)."""
        self._require_level(level)
        mixing = self._mixing if self.scene.colours else self._mixing[0]
        return Ledger.mixed(self._levels[level].ledgers, mixing)

    @property
    def outside(self) -> Array:
        """Flux [W] of lights that lie outside of each grid, (levels,) or (levels, colours)."""
        flux = self._outside @ self._mixing.T
        return np.asarray(flux if self.scene.colours else flux[:, 0])

    def look_up(self, points: ArrayLike, fade: float = FADE) -> Array:
        """Accumulated light ([colours,] size, ...) at world points (..., dimension) [m].

        In units of the scene's cells. fade: cells over which a grid gives way to the next coarser
        one in front of its border; 0 is a hard edge. See flatland.cascades.lookup.
        """
        if not (np.isfinite(fade) and fade >= 0):
            raise bad_input("fade", fade, "must be finite and at least 0")
        place = np.asarray(points, float)
        if place.ndim == 0 or place.shape[-1] != self.scene.grid.dimension:
            rule = f"must be (..., {self.scene.grid.dimension}) coordinates"
            raise bad_input("points", place.shape, rule)
        power = self.scene.grid.dimension - 1
        levels = [
            self.accumulated(number).values.astype(float) * 2.0 ** (-number * power)
            for number in range(len(self.grids))
        ]
        return looked_up(levels, self.grids, self.scene.grid, place, fade)

    def merge(self, fade: float = FADE) -> Field:
        """The look-up at the centres of all the scene's cells, as a field on the scene's grid."""
        cells = np.moveaxis(np.indices(self.scene.grid.shape), 0, -1) + 0.5
        values = self.look_up(self.scene.grid.to_world(cells), fade)
        return Field(self.scene.grid, self.basis, values.astype(self.precision))

    def _mixed(self, values: NDArray[np.floating]) -> NDArray[np.floating]:
        if self.scene.colours:
            return np.tensordot(self._mixing.astype(self.precision), values, 1)
        return values[0] * values.dtype.type(self._mixing[0, 0])

    def _require_level(self, level: int) -> None:
        whole = isinstance(level, Integral) and not isinstance(level, bool)
        if not whole or not 0 <= level < len(self.grids):
            raise bad_input("level", level, f"must be a whole number, 0 to {len(self.grids) - 1}")
