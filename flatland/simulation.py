"""The state machine that steps light through a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from flatland.devices import find_device
from flatland.errors import bad_input
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.ledger import Ledger
from flatland.level import PRECISIONS
from flatland.level_view import LevelView
from flatland.light_state import LightState, light_scale
from flatland.medium_step import warn_of_spread
from flatland.occlusion import Walls, given_occlusion
from flatland.octree import LevelRules, Octree
from flatland.scene import Scene
from flatland.skipped import Skip, skipped
from flatland.solvers import SolveReport
from flatland.spectra import require_range, require_room, spectra_of
from flatland.stencil import Scheme


class Simulation:
    """One scene, one stencil propagator, stepped (numerics §3), on one grid or an octree (§7).

    bands: angular bands. precision: "float64" or "float32". transmittance: (K, *shape), the share
    of the light leaving a cell along each of the stencil's offsets that nothing blocks; if given,
    the scene's occluders have no effect. What they do otherwise:
    blocking: "exact" cuts beams (flatland.blocking.exact), "fuzzy" reads a geometry volume, not in
    the first step (flatland.blocking.fuzzy), "none" lets light pass. strength: of the fuzzy one.
    bounces: what occluders stop comes back by their albedo, step after step; lamps then inject
    their own light only, since its first bounce is one of these. lights_block: area lights are
    black walls for light from elsewhere; they do not cut the links by which their own leaves.

    levels: of the octree, 1 for the uniform grid. normalization, level_factors, falloff, index,
    patience and skip say how levels are filled, stepped and read: see LevelRules. drop: light at
    the rim of what is lit with no coefficient above this part of the largest one at the start is
    not stepped on; the ledger says how much flux that was. 0 drops nothing.

    device: "cpu", or "cuda": fields live on a CUDA device, are stepped and solved there, and are
    copied back when they are looked at. It needs CuPy. Results are the same to rounding.

    `target` is the newest light, `source` what it was one step before, `accumulated` the sum of
    all, S_A = Σ_i S_i, all on level 0; `level(i)` gives them on any level and `merge()` one field
    from all. A run that was not filled by hand fills all levels itself, as `start` does.
    Scenes in colour are stepped once per linearly independent spectrum.
    A medium that fills the scene is met on every level by the length of that level's steps.
    Raises InputError for arguments that break a rule and for a grid that would not fit in memory;
    warns (SchemeWarning) of an unstable scheme, and of one that diffuses light by the wrong
    distance.
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
        normalization: str = "flux",
        level_factors: Sequence[float] | None = None,
        falloff: str = "cells",
        index: str = "finest",
        patience: float = 1.0,
        skip: bool = True,
        drop: float = 0.0,
        device: str = "cpu",
    ) -> None:
        if precision not in PRECISIONS:
            raise bad_input("precision", precision, "is unknown", PRECISIONS)
        rules = LevelRules(
            levels, normalization, level_factors, falloff, index, patience, skip, drop
        )
        if drop and scene.medium is not None:
            raise bad_input("drop", drop, "must be 0 in a medium, whose books need all light")
        grids = rules.grids(scene.grid)
        walls = Walls(blocking, strength, bounces, lights_block)
        #: Where fields are stepped: its `name` is "cpu", or what the device's maker calls it.
        self.device = find_device(device)
        self.scene, self.propagator, self.precision = scene, propagator, precision
        self.basis = basis_for(scene.grid.dimension, bands)
        self.stencil = propagator.stencil(self.basis)
        propagator.warn_if_unstable(self.stencil)
        blocked = blocking != "none" and len(scene.walls()) > 0
        require_room(scene, self.stencil, grids, precision, blocked)
        if transmittance is None:
            self._occlusion = walls.occlusion(scene, self.stencil)
        else:
            self._occlusion = given_occlusion(transmittance, self.stencil, grids)
        scales = self._take_lights()
        self.octree = Octree(
            scene, self.stencil, precision, scales, walls, self._occlusion, rules, self.device
        )
        warn_of_spread([level.medium for level in self.octree.levels])
        self.octree.levels[0].prepare(self._patterns)
        self.reset()

    def _take_lights(self) -> list[float]:
        """The patterns that are stepped, mixing (colours, P), and the patterns' scales."""
        self._patterns, self._mixing = spectra_of(self.scene, self.stencil, self._occlusion)
        scales = [light_scale(pattern.values) for pattern in self._patterns]
        require_range(self._mixing, scales, self.precision)
        return scales

    # -- actions --------------------------------------------------------------------------------

    def reset(self) -> None:
        """No light anywhere, iteration 0, empty books. Downsampled geometry stays."""
        self.octree.reset()
        self.converged: SolveReport | None = None
        self.merged: Field | None = None
        self._injected = False

    def relight(self, scene: Scene) -> None:
        """Take over the lights of another scene, dark and from a fresh start.

        What was made for the walls stays: what they stop, on every level, and what `solve` has set
        up. So the converged light of a lamp that moves costs little more than its iterations.
        Raises InputError if anything but lights differs, or if lights block.
        """
        mine = self.scene
        if (scene.grid, scene.occluders) != (mine.grid, mine.occluders):
            raise bad_input("scene", scene.title, "must have the same grid and occluders")
        if scene.colours != mine.colours:
            rule = f"must have as many colours, {mine.colours}, not {scene.colours}"
            raise bad_input("scene", scene.title, rule)
        if self.octree.walls.lights_block:
            raise bad_input("lights_block", True, "makes walls of the lights, which cannot move")
        self.scene = self.octree.scene = scene
        scales = self._take_lights()
        for level in self.octree.levels:
            level.rescale(scales)
        self.reset()

    def inject(self) -> None:
        """Put the scene's lights into the cells of level 0, from a fresh start.

        Coarse levels stay dark until `downsample`.
        """
        self.reset()
        scales = [state.scale for state in self._states]
        self.octree.inject([light * (1 / scale) for light, scale in zip(self._patterns, scales)])
        self._injected = True

    def downsample(self) -> None:
        """Fill all coarse levels with the light of level 0, as it is now; they start from there."""
        self.octree.downsample()

    def downsample_geometry(self) -> None:
        """Give all coarse levels the scene's walls. Without it, walls block nothing there."""
        self.octree.downsample_geometry()

    def start(self) -> None:
        """All that comes before the first step: inject, and fill the coarse levels."""
        self.inject()
        if len(self.octree.levels) > 1:
            self.downsample()
            if not self.octree.has_geometry:
                self.downsample_geometry()

    def step(self) -> None:
        """One iteration: every cell's light goes to its neighbours, on every level."""
        self.run(1)

    def run(self, iterations: int, progress: Callable[[int], object] | None = None) -> None:
        """Several iterations; starts first if nothing was injected.

        progress: called with the number of iterations just done; runs between batches.
        Raises InstabilityError when the light grows wild; the state before overflow is kept.
        """
        if not isinstance(iterations, Integral) or isinstance(iterations, bool) or iterations < 0:
            raise bad_input("iterations", iterations, "must be a whole number, at least 0")
        if self.converged is not None or not self._injected:
            self.start()
        last = self.iteration + int(iterations)
        self.octree.set_out(int(iterations))
        while self.iteration < last:
            self.octree.require_tame()
            count = min(last - self.iteration, self.octree.batch)
            self.octree.advance(count)
            if progress is not None:
                progress(count)
        self.octree.require_tame()

    def solve(self, tolerance: float = 1e-8, method: str = "auto") -> SolveReport:
        """Jump to the converged field (1 − A) S_A = S_0 of every level; books are closed with it.

        A contains what comes back from walls. If the first step is free of blocking, by A_free, it
        is done first: S_A = S_0 + (1 − A)⁻¹ A_free S_0.

        tolerance: relative residual ‖S_0 − (1 − A) S_A‖ / ‖S_0‖. method: see `solve_converged`.
        For a clamped scheme this is the answer of its linear twin. Raises ConvergenceError if the
        tolerance was not reached, InstabilityError if the scheme's radius says there is no answer.
        """
        self.start()
        self._injected = False  # also if this fails, stepping starts afresh
        self.octree.levels[0].warn_of_clamp(2)
        self.converged = self.octree.solve(tolerance, method)
        return self.converged

    def merge(self, blend: float | None = None, name: str = "accumulated") -> Field:
        """One field on the cells of level 0, each read from the level that `index` names.

        blend: None reads whole elements (the octree thesis 4.2); a number fades levels into each
        other over so many cells of the coarser one, see `flatland.octree.blended`. name: "source",
        "target" or "accumulated". With one level it is that level's field. Kept in `merged`.
        """
        if name not in _BUFFERS:
            raise bad_input("name", name, "is unknown", _BUFFERS)
        index = self.index
        spectra = range(len(self._states))
        buffer = _BUFFERS[name]
        self.merged = self._field(
            [self.octree.merge(each, buffer, index, blend) for each in spectra], self.scene.grid
        )
        return self.merged

    def explain(self) -> list[Skip]:
        """What this run has left out so far because nothing needs it, and what that saved."""
        return skipped(self)

    # -- what can be looked at ------------------------------------------------------------------

    @property
    def iteration(self) -> int:
        """Steps since injection."""
        return self.octree.iteration

    @property
    def levels(self) -> int:
        """Number of octree levels; 1 for the uniform grid."""
        return len(self.octree.levels)

    @property
    def index(self) -> NDArray[np.int8]:
        """The level that each cell of level 0 is read from in a merge, (*shape).

        One for all colours: a place that light of any colour has reached counts as lit.
        """
        return self.octree.index()

    @property
    def source(self) -> Field:
        """The light of one step before, on level 0; dark before the first step."""
        return self.level(0).source

    @property
    def target(self) -> Field:
        """The newest light, on level 0: what the next step sends on."""
        return self.level(0).target

    @property
    def accumulated(self) -> Field:
        """S_A = Σ_i S_i of level 0, injection included: what the exact answer is compared with."""
        return self.level(0).accumulated

    @property
    def ledger(self) -> Ledger:
        """Where the flux of level 0 went, () or (colours,)."""
        return self.level(0).ledger

    def level(self, number: int) -> LevelView:
        """What level `number` holds. Raises InputError for a level that is not there."""
        whole = isinstance(number, Integral) and not isinstance(number, bool)
        if not whole or not 0 <= number < self.levels:
            raise bad_input("level", number, f"must be a whole number, 0 to {self.levels - 1}")
        return LevelView(self, int(number))

    @property
    def field_bytes(self) -> int:
        """Memory of source, target and accumulated light, of all levels and spectra."""
        fields = 3 * len(self._states)
        layouts = [level.layout for level in self.octree.levels]
        return fields * sum(layout.size * layout.dtype.itemsize for layout in layouts)

    @property
    def _states(self) -> list[LightState]:
        return self.octree.levels[0].states

    def _level_ledger(self, number: int) -> Ledger:
        mixing = self._mixing if self.scene.colours else self._mixing[0]
        return Ledger.mixed(self.octree.level(number).ledgers, mixing)

    def _level_field(self, number: int, name: str) -> Field:
        level = self.octree.level(number)
        return self._field(level.values(_BUFFERS[name]), level.grid)

    def _field(self, values: list[NDArray[np.floating]], grid: Grid) -> Field:
        if self.scene.colours:
            mixing = self._mixing.astype(self.precision)
            return Field(grid, self.basis, np.tensordot(mixing, np.array(values), 1))
        factor = self._mixing[0, 0]
        mono = values[0] if factor == 1.0 else values[0] * factor
        return Field(grid, self.basis, mono)


#: Names of fields and of the buffers that hold them.
_BUFFERS = {"source": "source", "target": "target", "accumulated": "total"}
