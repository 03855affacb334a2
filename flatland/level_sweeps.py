"""The sweeps of one grid, compiled when light needs them."""

from __future__ import annotations

from flatland.folding import Fold
from flatland.kernels import Layout, Sweep
from flatland.occlusion import Occlusion
from flatland.stencil import Stencil


class LevelSweeps:
    """Steps of light on one grid, among the same walls, for the whole of it and for halves.

    sums: components whose sums the books need.
    """

    def __init__(
        self, stencil: Stencil, layout: Layout, occlusion: Occlusion, sums: tuple[int, ...]
    ) -> None:
        self.stencil, self.layout, self.occlusion, self.sums = stencil, layout, occlusion, sums
        self._usual: dict[Fold, tuple[Sweep, ...]] = {}
        self._free: dict[Fold, Sweep] = {}

    def usual(self, fold: Fold, spectra: int) -> list[Sweep]:
        """The sweep of each spectrum; where all walls are alike, one for all."""
        if fold not in self._usual:
            occlusion = fold.occlusion(self.occlusion) if fold.axes else self.occlusion
            layout = fold.layout(self.layout)
            sweep = Sweep(self.stencil, layout, occlusion.transmittance, self.sums)
            parts = occlusion.reflections or (None,)
            self._usual[fold] = tuple(sweep.reflecting(part) for part in parts)
        sweeps = self._usual[fold]
        return list(sweeps) if len(sweeps) > 1 else list(sweeps) * spectra

    def free(self, fold: Fold) -> Sweep | None:
        """For a first step that is not blocked; None if it is like all others."""
        if not self.occlusion.free_first_step:
            return None
        if fold not in self._free:
            layout = fold.layout(self.layout)
            self._free[fold] = Sweep(self.stencil, layout, None, self.sums)
        return self._free[fold]
