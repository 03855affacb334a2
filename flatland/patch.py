"""Light in a box of cells, dark elsewhere: what a lamp in a large grid is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.box import Box, cells_of, is_empty, trimmed, whole

Values = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class Patch:
    """values: (size, *cells of the box). box: first and last (excluded) cell along each axis."""

    values: Values
    box: Box

    @classmethod
    def around(cls, field: Values) -> Patch:
        """The light of a whole field (size, *shape), in the smallest box that holds it all."""
        box = trimmed(field, whole(field.shape[1:]))[0]
        return cls(np.ascontiguousarray(field[cells_of(box)]), box)

    @classmethod
    def everywhere(cls, field: Values) -> Patch:
        """A whole field as it is."""
        return cls(field, whole(field.shape[1:]))

    def __mul__(self, factor: float) -> Patch:
        return Patch(self.values * factor, self.box)

    def trimmed(self) -> Patch:
        """The same light in the smallest box."""
        if is_empty(self.box):
            return self
        inner = trimmed(self.values, whole(self.values.shape[1:]))[0]
        if is_empty(inner):
            return Patch(self.values[cells_of(inner)], inner)
        box = tuple(
            (first + begin, first + end) for (first, _), (begin, end) in zip(self.box, inner)
        )
        return Patch(self.values[cells_of(inner)], box)

    def on(self, shape: Sequence[int]) -> Values:
        """The whole field, (size, *shape)."""
        field = np.zeros((len(self.values), *shape), self.values.dtype)
        field[cells_of(self.box)] = self.values
        return field
