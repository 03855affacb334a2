"""What a scene's walls do to the links of a stencil: stop light, and send some of it back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatland.blocking import (
    Surfels,
    exact_reflection,
    exact_transmittance,
    fuzzy_reflection,
    fuzzy_transmittance,
    surfels_of,
)
from flatland.errors import bad_input
from flatland.grid import Grid, cells_on
from flatland.injectors.area import AreaLight
from flatland.injectors.lamp import Lamp
from flatland.kernels import Reflection
from flatland.scene import Scene
from flatland.sources import Wall
from flatland.stencil import Stencil

Array = NDArray[np.float64]

BLOCKING = ("exact", "fuzzy", "none")


@dataclass(frozen=True)
class Occlusion:
    """transmittance: τ(x, d), (K, *shape), or None: nothing blocks.

    reflections: what comes back, () if nothing does, else one for all colours or one for each.
    free_first_step: the first step after injection is not blocked (Kaplanyan & Dachsbacher 2010,
    3.3: light starts among the surfels of the very surface that sends it).
    """

    transmittance: Array | None = None
    reflections: tuple[Reflection, ...] = ()
    free_first_step: bool = False

    @property
    def coloured(self) -> bool:
        """Whether every colour has to be stepped by itself."""
        return len(self.reflections) > 1


@dataclass(frozen=True)
class Walls:
    """How walls are read. See `Simulation` for the meaning of each."""

    blocking: str = "exact"
    strength: float = 1.0
    bounces: bool = True
    lights_block: bool = False

    def __post_init__(self) -> None:
        if self.blocking not in BLOCKING:
            raise bad_input("blocking", self.blocking, "is unknown", BLOCKING)
        if not (np.isfinite(self.strength) and self.strength >= 0):
            raise bad_input("strength", self.strength, "must be finite and at least 0")

    def occlusion(
        self, scene: Scene, stencil: Stencil, grid: Grid | None = None, level: int = 0
    ) -> Occlusion:
        """What the scene's occluders, and its area lights if they block, do to a stencil.

        grid: another grid than the scene's own, anywhere. level: of that grid's octree. Exact
        beams are cut anew by coarse cells; the geometry volume is downsampled.
        """
        lights = _blocking_lights(scene) if self.lights_block else []
        walls = [*scene.walls(), *(wall for _, wall in lights)]
        if self.blocking == "none" or not walls:
            return Occlusion()
        place = _Place(grid or scene.grid, level)
        tau = self._transmittance(place, stencil, walls)
        if tau is not None and lights:
            tau = self._freed(scene, place, stencil, lights, tau)
        if tau is None:
            return Occlusion()
        reflections = self._reflections(place, stencil, walls, tau) if self.bounces else ()
        return Occlusion(tau, reflections, self.blocking == "fuzzy")

    def _transmittance(
        self, place: _Place, stencil: Stencil, walls: Sequence[Wall]
    ) -> Array | None:
        if self.blocking == "exact":
            return exact_transmittance(place.grid, walls, stencil.offsets)
        surfels = place.surfels(walls)
        return fuzzy_transmittance(
            place.grid.shape, surfels, stencil.offsets, stencil.basis, self.strength
        )

    def _freed(
        self,
        scene: Scene,
        place: _Place,
        stencil: Stencil,
        lights: Sequence[tuple[AreaLight, Wall]],
        tau: Array,
    ) -> Array:
        """τ without a light on the links that lead from the cells it shines in to its front."""
        result = tau.copy()
        walls = scene.walls()
        for number, (light, _) in enumerate(lights):
            others = [wall for i, (_, wall) in enumerate(lights) if i != number]
            without = self._transmittance(place, stencil, [*walls, *others])
            lit = light.deposit(scene.grid, stencil.basis).cells
            cells = tuple(same_places(scene.grid, lit, place.grid))
            for d in np.flatnonzero(stencil.offsets @ light.normal >= 0):
                open_share = 1.0 if without is None else without[(d, *cells)]
                result[(d, *cells)] = np.maximum(result[(d, *cells)], open_share)
        return result

    def _reflections(
        self, place: _Place, stencil: Stencil, walls: Sequence[Wall], tau: Array
    ) -> tuple[Reflection, ...]:
        albedo = np.array([wall.albedo for wall in walls])
        if not albedo.any():
            return ()
        if np.all(albedo == albedo[:, :1]):
            # Grey walls do the same to every colour.
            albedo = albedo[:, :1]
            walls = [replace(wall, albedo=share) for wall, share in zip(walls, albedo)]
        offsets, basis = stencil.offsets, stencil.basis
        if self.blocking == "exact":
            return tuple(exact_reflection(place.grid, walls, offsets, basis, tau))
        return tuple(fuzzy_reflection(place.surfels(walls), albedo, offsets, basis, tau))


def given_occlusion(
    values: NDArray[np.floating], stencil: Stencil, grids: Sequence[Grid]
) -> Occlusion:
    """Transmittances (K, *shape) that a caller made. Raises InputError for others."""
    if len(grids) > 1:
        rule = "cannot be given for more than one level"
        raise bad_input("transmittance", np.shape(values), rule)
    expected = (len(stencil.offsets), *grids[0].shape)
    array = np.asarray(values, float)
    if array.shape != expected:
        raise bad_input("transmittance", array.shape, f"must be of shape {expected}")
    if not np.all((array >= 0) & (array <= 1)):
        raise bad_input("transmittance", values, "must lie between 0 and 1")
    return Occlusion(array)


class _Place:
    """Where walls are met: a level of the octree over a grid."""

    def __init__(self, finest: Grid, level: int) -> None:
        self.finest, self.level, self.grid = finest, level, finest
        for _ in range(level):
            self.grid = self.grid.coarsen()

    def surfels(self, walls: Sequence[Wall]) -> Surfels:
        """The geometry volume: injected into level 0, downsampled to the others."""
        surfels = surfels_of(self.finest, walls)
        for _ in range(self.level):
            surfels = surfels.coarsened()
        return surfels


def same_places(grid: Grid, cells: NDArray[np.int64], other: Grid) -> NDArray[np.int64]:
    """Cells of another grid in which the centres of cells (dimension, K) lie, each once."""
    places, inside = cells_on(grid, cells, other)
    return np.unique(places[:, inside], axis=1)


def without_first_bounces(scene: Scene) -> Scene:
    """The scene with only the own light of its lamps, for a run that follows bounces itself.

    A lamp that injects its bounce alone is left as it is: its own light is not propagated.
    """
    lights = [
        light.model_copy(update={"part": "direct"})
        if isinstance(light, Lamp) and light.part == "both"
        else light
        for light in scene.lights
    ]
    return scene.model_copy(update={"lights": tuple(lights)})


def _blocking_lights(scene: Scene) -> list[tuple[AreaLight, Wall]]:
    """Area lights and the black walls that they are."""
    lights = [light for light in scene.lights if isinstance(light, AreaLight)]
    return [(light, light.blocker(scene.colours)) for light in lights]
