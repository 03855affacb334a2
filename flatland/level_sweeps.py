"""The sweeps of one grid, compiled when light needs them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from flatland.folding import Fold
from flatland.kernels import Layout
from flatland.kernels.any_sweep import AnySweep
from flatland.occlusion import Occlusion

#: Compiles steps on a layout, from τ and the components whose sums they report.
Make = Callable[[Layout, NDArray[np.float64] | None, tuple[int, ...]], AnySweep]


class LevelSweeps:
    """Steps of light on one grid, among the same walls, for the whole of it and for halves.

    sums: components whose sums the books need.
    """

    def __init__(
        self, make: Make, layout: Layout, occlusion: Occlusion, sums: tuple[int, ...]
    ) -> None:
        self._make, self._layout, self._occlusion, self._sums = make, layout, occlusion, sums
        #: By the axes that are folded.
        self._usual: dict[tuple[int, ...], tuple[AnySweep, ...]] = {}
        self._free: dict[tuple[int, ...], AnySweep] = {}

    def usual(self, fold: Fold, spectra: int) -> list[AnySweep]:
        """The sweep of each spectrum; where all walls are alike, one for all."""
        if fold.axes not in self._usual:
            occlusion = fold.occlusion(self._occlusion)
            sweep = self._make(fold.layout(self._layout), occlusion.transmittance, self._sums)
            parts = occlusion.reflections or (None,)
            self._usual[fold.axes] = tuple(sweep.reflecting(part) for part in parts)
        sweeps = self._usual[fold.axes]
        return list(sweeps) if len(sweeps) > 1 else list(sweeps) * spectra

    def free(self, fold: Fold) -> AnySweep | None:
        """For a first step that is not blocked; None if it is like all others."""
        if not self._occlusion.free_first_step:
            return None
        if fold.axes not in self._free:
            self._free[fold.axes] = self._make(fold.layout(self._layout), None, self._sums)
        return self._free[fold.axes]
