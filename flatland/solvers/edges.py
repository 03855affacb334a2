"""Where light between mirrors differs from light in a scene: at the border and on walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.kernels import Sweep
from flatland.solvers.mirrored import Mirrored, Waves

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Light stopped on a link that is rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Links:
    """Light on its way along one offset that mirrors let in and the scene does not.

    rows: cells where it arrives, as numbers into `Edges.cells`. places: cells (L,) it comes from,
    as positions in a component of a field. share: (L,), 1 − τ; 1 where it comes from outside.
    """

    rows: Integers
    places: Integers
    share: Array


class Edges:
    """The cells where 1 − A of a scene is not 1 − A between mirrors, and the difference there.

    cells: (M, dimension), each once. links: one per offset. local: (cells, blocks) of what walls
    send back into cells.
    """

    def __init__(self, sweep: Sweep, mirrored: Mirrored) -> None:
        stencil, shape = sweep.stencil, sweep.layout.shape
        self.mirrored, self.transfer = mirrored, mirrored.transfer
        self._extent = tuple(n + 1 for n in mirrored.periods)
        shares = [_stopped(sweep, d) for d in range(len(stencil.offsets))]
        touched = np.any([share > _ROUNDING for share in shares], axis=0)
        reflection = sweep.reflection
        if reflection is not None:
            touched[tuple(reflection.cells.T)] = True
        self.cells = np.argwhere(touched)
        self.places = self.place(self.cells)
        number = np.full(shape, -1)
        number[touched] = np.arange(len(self.cells))
        self.links = []
        for offset, share in zip(stencil.offsets, shares):
            there = share[touched]
            rows = np.flatnonzero(there > _ROUNDING)
            self.links.append(Links(rows, self.place(self.cells[rows] - offset), there[rows]))
        self.local_rows = np.zeros(0, np.int64)
        self.local = np.zeros((0, stencil.basis.size, stencil.basis.size))
        if reflection is not None:
            self.local_rows = number[tuple(reflection.cells.T)]
            self.local = reflection.blocks(stencil)

    def place(self, cells: Integers) -> Integers:
        """Positions of cells in one component of a field, the lower mirror's cell in front."""
        return np.asarray(np.ravel_multi_index(tuple((cells + 1).T), self._extent))

    def spread(self, values: Array) -> Waves:
        """A field with (M, size) in the cells, zero elsewhere."""
        field = self.mirrored.field()
        field.reshape(len(field), -1)[:, self.places] = values.T
        return field

    def difference(self, field: Waves) -> Array:
        """(A between mirrors − A of the scene) of a field, in the cells, (M, size)."""
        flat = field.reshape(len(field), -1)
        result = np.zeros((len(self.cells), len(field)))
        for links, transfer in zip(self.links, self.transfer):
            light = flat[:, links.places] * links.share
            result[links.rows] += (transfer @ light).T
        back = flat[:, self.places[self.local_rows]].T
        result[self.local_rows] -= np.einsum("mij,mj->mi", self.local, back)
        return result


def _stopped(sweep: Sweep, d: int) -> Array:
    """Share of the light that arrives along offset d, by the cell it would get to, (*shape)."""
    shape, offset = sweep.layout.shape, sweep.stencil.offsets[d]
    result = np.ones(shape)
    stay = tuple(slice(max(0, -o), n - max(0, o)) for o, n in zip(offset, shape))
    arrive = tuple(slice(max(0, o), n - max(0, -o)) for o, n in zip(offset, shape))
    result[arrive] = 0.0
    if sweep.open_share is not None:
        result[arrive] = 1.0 - sweep.open_share[d][stay]
    return result
