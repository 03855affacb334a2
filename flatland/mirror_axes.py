"""Along which axes half a grid is enough."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

from flatland.folding import wall_axes
from flatland.kernels import Layout
from flatland.kernels.arrivals import written_operations
from flatland.kernels.box import is_empty
from flatland.occlusion import Occlusion
from flatland.patch import Patch
from flatland.stencil import Stencil
from flatland.symmetry import drawn_rounding, light_axes, scheme_axes

#: Multiply-adds a step below which a grid is not folded: images take their time, too. Measured
#: for half a grid, on one thread: 1.1 to 1.2 times as fast here; quarters 1.3 to 1.4.
WORTH_FOLDING = 200_000
#: The same where every step is a call of its own, with images made anew.
WORTH_FOLDING_ALONE = 600_000
#: Cells along an axis below which its layer of images is too large a part of the half.
FEWEST_CELLS = 16


class MirrorAxes:
    """Axes along which one scheme, the walls of one grid and some light are their own image.

    possible: whether there is any need to look. scatters: all cells send light back, in a medium.
    """

    def __init__(self, stencil: Stencil, layout: Layout, possible: bool, scatters: bool) -> None:
        self.stencil, self.layout, self.shape = stencil, layout, layout.shape
        self._possible, self._scatters = possible, scatters
        self._occlusion = Occlusion()
        self._of_walls: tuple[int, ...] | None = None

    def block(self, occlusion: Occlusion) -> None:
        """Other walls."""
        self._occlusion, self._of_walls = occlusion, None

    def of(self, light: Iterable[Patch]) -> tuple[int, ...]:
        """Axes that all patches of some light can be folded along."""
        axes = self._worthy()
        for patch in light if axes else ():
            axes = self._of_light(patch, axes)
        if axes and self._of_walls is None:
            found = scheme_axes(self.stencil)
            self._of_walls = wall_axes(self._occlusion, self.stencil, self.shape, found)
        return tuple(axis for axis in axes if axis in (self._of_walls or ()))

    def _worthy(self) -> tuple[int, ...]:
        """Axes along which it would pay."""
        alone = self.stencil.clamp or self._occlusion.reflections or self._scatters
        if not self._possible or self._work < (WORTH_FOLDING_ALONE if alone else WORTH_FOLDING):
            return ()
        return tuple(axis for axis, cells in enumerate(self.shape) if self._shortens(axis, cells))

    @cached_property
    def _work(self) -> int:
        """Operations of a step."""
        return written_operations(self.stencil) * math.prod(self.shape)

    def _shortens(self, axis: int, cells: int) -> bool:
        """Whether half of an axis is less work: rows are swept in whole vectors."""
        lanes = self.layout.lanes
        shorter = axis < len(self.shape) - 1 or -(-cells // 2) <= (cells - 1) // lanes * lanes
        return cells >= FEWEST_CELLS and shorter

    def _of_light(self, patch: Patch, axes: tuple[int, ...]) -> tuple[int, ...]:
        """Those of some axes along which light is its own image; looks only where it is lit."""
        patch = patch.trimmed()
        if not axes or is_empty(patch.box):
            return axes
        ends = zip(patch.box, self.shape)
        centred = {axis for axis, ((first, last), n) in enumerate(ends) if first + last == n}
        tolerance = drawn_rounding(self.shape)
        return light_axes(patch.values, self.stencil.basis, sorted(centred & set(axes)), tolerance)
