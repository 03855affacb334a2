"""Faces of cells cut where segments meet them, so that light on a piece does not jump."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.transport.cell_items import CellItems, Items

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells; cuts nearer to one another, or to the end of a face, leave no piece between them.
SPECK = 1e-9


class Pieces(NamedTuple):
    """Pieces of faces, those of face k are first[k] … first[k + 1] - 1.

    ends: (K, 2), coordinates along the face. covered: (K,), whether a segment lies on the piece.
    """

    first: Counts
    ends: Array
    covered: NDArray[np.bool_]


class FacePieces(NamedTuple):
    """Places of faces as in `CellItems`."""

    x_faces: Pieces
    y_faces: Pieces


def cut_faces(items: CellItems, shape: tuple[int, int]) -> FacePieces:
    """All faces of a grid in pieces."""
    nx, ny = shape
    return FacePieces(
        _cut(items, items.x_faces, 0, (nx + 1) * ny, ny, ny),
        _cut(items, items.y_faces, 1, nx * (ny + 1), nx, ny + 1),
    )


def _cut(
    items: CellItems, on_faces: Items, axis: int, count: int, width: int, stride: int
) -> Pieces:
    """Faces across `axis`; width: cells along a line of them. stride: of the first index."""
    lines = np.concatenate([on_faces.ends.reshape(-1, 2), items.cells.ends.reshape(-1, 2)])
    lines = lines[lines[:, axis] == np.rint(lines[:, axis])]
    along = np.clip(np.floor(lines[:, 1 - axis]).astype(np.int64), 0, width - 1)
    line = lines[:, axis].astype(np.int64)
    face = line * stride + along if axis == 0 else along * stride + line
    start = (np.arange(count) % stride if axis == 0 else np.arange(count) // stride).astype(float)
    owner = np.concatenate([np.arange(count), np.arange(count), face])
    place = np.concatenate([start, start + 1.0, lines[:, 1 - axis]])
    order = np.lexsort((place, owner))
    owner, place = owner[order], place[order]
    kept = np.flatnonzero((owner[1:] == owner[:-1]) & (place[1:] - place[:-1] > SPECK))
    ends = np.stack([place[kept], place[kept + 1]], axis=1)
    first = np.searchsorted(owner[kept], np.arange(count + 1))
    return Pieces(first, ends, _covered(on_faces, axis, owner[kept], ends))


def _covered(on_faces: Items, axis: int, faces: Counts, ends: Array) -> NDArray[np.bool_]:
    """Which pieces (K, 2) of faces (K,) a segment lies on."""
    middles, result = ends.mean(axis=1), np.zeros(len(ends), bool)
    parts = np.sort(on_faces.ends[:, [1 - axis, 3 - axis]], axis=1)
    owner = np.repeat(np.arange(len(on_faces.first) - 1), np.diff(on_faces.first))
    for face, (low, high) in zip(owner.tolist(), parts.tolist()):
        here = slice(*np.searchsorted(faces, [face, face + 1]))
        result[here] |= (middles[here] > low) & (middles[here] < high)
    return result
