"""Along which axes half a grid is enough."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from flatland.folding import wall_axes
from flatland.kernels.box import Box, cells_of, is_empty, trimmed
from flatland.occlusion import Occlusion
from flatland.stencil import Stencil
from flatland.symmetry import light_axes, scheme_axes

Values = NDArray[np.floating]

#: Multiply-adds of a step below which a grid is not folded.
WORTH_FOLDING = 0


class MirrorAxes:
    """Axes along which one scheme, the walls of one grid and some light are their own image.

    possible: whether there is any need to look.
    """

    def __init__(self, stencil: Stencil, shape: tuple[int, ...], possible: bool) -> None:
        self.stencil, self.shape, self._possible = stencil, shape, possible
        self._occlusion = Occlusion()
        self._of_walls: tuple[int, ...] | None = None

    def block(self, occlusion: Occlusion) -> None:
        """Other walls."""
        self._occlusion, self._of_walls = occlusion, None

    def of(self, light: Iterable[tuple[Values, Box]]) -> tuple[int, ...]:
        """Axes that all fields (size, *shape) of some light can be folded along.

        With each a box outside of which it is dark.
        """
        axes = self._worthy()
        for values, box in light:
            axes = _of_light(values, box, self.stencil, axes)
        if axes and self._of_walls is None:
            found = scheme_axes(self.stencil)
            self._of_walls = wall_axes(self._occlusion, self.stencil, self.shape, found)
        return tuple(axis for axis in axes if axis in (self._of_walls or ()))

    def _worthy(self) -> tuple[int, ...]:
        """Axes along which it would pay."""
        if not self._possible:
            return ()
        work = np.count_nonzero(self.stencil.transfer) * int(np.prod(self.shape))
        if work < WORTH_FOLDING:
            return ()
        return tuple(axis for axis, cells in enumerate(self.shape) if cells >= 4)


def _of_light(values: Values, box: Box, stencil: Stencil, axes: tuple[int, ...]) -> tuple[int, ...]:
    """Those of some axes along which light is its own image, looking no further than it is lit."""
    if not axes:
        return axes
    box = trimmed(values, box)[0]
    if is_empty(box):
        return axes
    ends = zip(box, values.shape[1:])
    centred = {axis for axis, ((first, last), n) in enumerate(ends) if first + last == n}
    return light_axes(values[cells_of(box)], stencil.basis, sorted(centred & set(axes)))
