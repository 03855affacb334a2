"""All rays of all maps, from what shines to what they meet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics
from flatland.kernels.threads import run_shared, thread_count
from propagators.maps.fans import make_fan
from propagators.maps.marching import march
from propagators.maps.rays import Fan, Sources, Tally
from propagators.transport.cell_items import CellItems, items_in_cells
from propagators.transport.problem import DirectProblem

Array = NDArray[np.float64]

#: Waking another thread costs as much as about this many crossings of cells.
_FEW = 20_000


@dataclass(frozen=True, eq=False)
class Maps:
    """angles: M of each map. rays: K for each cell across. lights_block: see `Sources`."""

    problem: DirectProblem
    angles: int
    rays: int
    lights_block: bool = True

    @cached_property
    def _items(self) -> CellItems:
        return items_in_cells(self.problem.surfaces.segments, self.problem.shape)

    @cached_property
    def _blocks(self) -> NDArray[np.bool_]:
        surfaces = self.problem.surfaces
        if self.lights_block:
            return np.ones(surfaces.count, bool)
        lights = len(self.problem.geometry.emitters)
        return surfaces.arrangement.owners[surfaces.owners] >= lights

    @cached_property
    def _full(self) -> Fan:
        return make_fan(self.angles, self.rays, self.problem.basis)

    @cached_property
    def _bare(self) -> Fan:
        """Without coefficients."""
        return make_fan(self.angles, self.rays, CircularHarmonics(1))

    @cached_property
    def passed(self) -> Array:
        """Flux (E, 2, 1) that rays carry from each side at radiance 1; 0 where no ray met it."""
        return self._run(self._bare, np.zeros(self._shape), None, 0).passed[:, :, None]

    @property
    def _shape(self) -> tuple[int, int, int]:
        return self.problem.surfaces.count, 2, self.problem.colours

    @cached_property
    def light_radiance(self) -> Array:
        """What lights send (E, 2, C), scaled so that the flux of each side of each light is exact.

        0 where no ray meets any piece of it.
        """
        surfaces = self.problem.surfaces
        owners = surfaces.arrangement.owners[surfaces.owners]
        _, light = np.unique(owners, return_inverse=True)
        wanted = np.zeros((light.max(initial=-1) + 1, *self._shape[1:]))
        carried = np.zeros_like(wanted)
        np.add.at(wanted, light, 2 * surfaces.lengths[:, None, None] * surfaces.radiance)
        np.add.at(carried, light, self.passed * surfaces.radiance)
        met = carried > 0
        scale = np.where(met, wanted / np.where(met, carried, 1.0), 0.0)
        return np.asarray(surfaces.radiance * scale[light])

    @property
    def missed(self) -> Array:
        """Flux (C,) of lights that no ray meets."""
        sent = np.sum(self.passed * self.light_radiance, axis=(0, 1))
        return np.where(np.isclose(sent, self.problem.light_flux, rtol=1e-9, atol=0), 0.0,
                        self.problem.light_flux - sent)  # fmt: skip

    def run(
        self,
        sent: Array,
        cells: Array | None = None,
        lights: bool = True,
        deposit: bool = True,
    ) -> Tally:
        """Follow the flux that walls send, (E, 2, C), and the light of cells, (C, size, nx, ny).

        lights: whether they shine too. deposit: whether cells are looked at; if not, the light of
        cells may have one band only.
        """
        met = self.passed > 0
        radiance = np.where(met, sent / np.where(met, self.passed, 1.0), 0.0)
        if lights:
            radiance = radiance + self.light_radiance
        whole = deposit or (cells is not None and cells.shape[1] > 1)
        fan = self._full if whole else self._bare
        size = self.problem.basis.size if deposit else 0
        return self._run(fan, radiance, cells, size)

    def _run(self, fan: Fan, radiance: Array, cells: Array | None, size: int) -> Tally:
        (nx, ny), colours = self.problem.shape, self.problem.colours
        given = np.empty((0, 0, 0))
        if cells is not None:
            given = np.ascontiguousarray(cells.transpose(2, 3, 0, 1)).reshape(nx, ny, -1)
        medium = self.problem.scene.medium
        optical = 0.0 if medium is None else medium.extinction * self.problem.geometry.grid.spacing
        sources = Sources(np.ascontiguousarray(radiance), self._blocks, given, optical)
        count = len(fan.directions) * self.rays * nx * ny
        tallies = [
            Tally(
                np.zeros((nx, ny, colours * size)),
                np.zeros(self._shape),
                np.zeros(self._shape[:2]),
                np.zeros(colours),
                np.zeros((nx, ny, colours)),
            )
            for _ in range(thread_count() if count > _FEW else 1)
        ]

        def follow(party: int, parties: int) -> None:
            march(party, parties, fan, self._items, sources, tallies[party])

        run_shared(follow, len(tallies))
        for other in tallies[1:]:
            for mine, theirs in zip(tallies[0], other):
                mine += theirs
        return tallies[0]
