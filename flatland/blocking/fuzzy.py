r"""Fuzzy blocking: a coarse picture of all walls as blocking potentials at the corners of cells.

::

    o-------o-------o    o: nodes of the geometry volume, the corners of the cells (*). A surfel
    |       |       |    belongs to the nearest node. Light that goes from * to * passes the face
    |   *   |   *   |    between them, at whose centre the potentials of its nodes are averaged
    |       |       |    (2 nodes in 2D, 4 in 3D; a diagonal passes through a corner, 1 node, or in
    o-------o-------o    3D through an edge, 2 nodes).

Kaplanyan & Dachsbacher 2010, section 3.2, after Sillion 1995: a surfel of area A_s and normal n_s
blocks light that travels along d with the probability B(−d), B(ω) = A_s h^{1−D} ⟨n_s|ω⟩₊, which is
projected to the basis of the light, added up at the nodes and read towards the light:
τ = 1 − clamp(strength · B(−d), 0, 1).

Sides. A lobe for each side of a wall would cancel in two bands (Kirsch 2010, 5.1: what is left of
|cos| is nearly a constant), so one side is asked at a time. A thin wall is asked with the side
that faces the light. A closed surface, whose normals point outwards, is seen in two views, from
outside and from inside (a light may be in there); as the paper merges several views of one
surface, the larger potential counts, not their sum: the sum would block twice as much as a thin
closed thing covers.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.blocking.mirrors import EDGE_ON, without_idle_cells
from flatland.blocking.surfels import Surfels
from flatland.errors import bad_input
from flatland.harmonics import AngularBasis
from flatland.kernels.reflection import Reflection

Array = NDArray[np.float64]
Cells = NDArray[np.int64]


def fuzzy_transmittance(
    shape: tuple[int, ...],
    surfels: Surfels,
    offsets: ArrayLike,
    basis: AngularBasis,
    strength: float = 1.0,
) -> Array | None:
    """τ(x, d), (K, *shape), or None where nothing blocks: then there is no geometry volume.

    shape: of the grid. strength: multiplies all potentials; with 1, a wall on faces stops light
    that meets it head-on but for 18 % with 2 bands (B(−d) = 1/π + 1/2; 25 % in 3D, where B(−d) =
    1/4 + 1/2), and all but all of it with more.

    What it gets wrong: nearly everything but the average. A wall that lies on centres is shared
    by two faces, each of which stops half of the light, so that a quarter passes. A slanted wall
    leaks, and one along the light stops what it should let by (1/π per cell with 2 bands). A
    diagonal is stopped as if its beam were one cell wide and not √2: by 1/√2 of a wall on faces, by
    1/√3 along the diagonal of a cell in 3D. Measured with n = 4 in
    a tilted closed box of 12 x 11 cells: 10 % (LPV), 24 % (DOM4) and 31 % (DOM8) of its light get
    out with strength 1, 0.3 %, 0.3 % and 10 % with strength 2; nothing with exact blocking. In a
    turned closed box of 6.5 x 6 x 7 cells: 5 % (LPV), 21 % (DOM6) and 36 % (DOM26) with strength 1,
    0.3 %, 0.3 % and 10 % with strength 2.
    """
    if not (np.isfinite(strength) and strength >= 0):
        raise bad_input("strength", strength, "must be finite and at least 0")
    steps = np.asarray(offsets, np.int64)
    if not surfels.areas.size or strength == 0:
        return None
    tau = np.ones((len(steps), *shape))
    for open_share, step in zip(tau, steps):
        views = [view.potential(step) for view in _views(shape, surfels, step, basis)]
        open_share -= np.clip(strength * np.max(views, axis=0), 0, 1)
    return tau if tau.min() < 1 else None


def fuzzy_reflection(
    surfels: Surfels,
    albedo: ArrayLike,
    offsets: ArrayLike,
    basis: AngularBasis,
    transmittance: Array,
) -> list[Reflection]:
    """What walls send back of what they stop, one reflection per colour of their albedo.

    Kaplanyan & Dachsbacher 2010, section 7: reflected light has the distribution of the blocker,
    B(ω). Here it is scaled so that it carries albedo times the flux that was stopped, and goes
    back into the cell that sent it; the paper looks one cell further, reflects that much again
    without taking it away, and so may gain energy. albedo: (segments, colours).

    What it gets wrong: a node knows no order of surfaces, so the lobes of all walls near it are
    mixed, those that turn away from the light as well.
    """
    steps = np.asarray(offsets, np.int64)
    shape = transmittance.shape[1:]
    share = np.asarray(albedo, float)[surfels.walls]
    cells = np.argwhere((transmittance < 1).any(axis=0))
    lobes = np.zeros((share.shape[1], len(cells), len(steps), basis.size))
    for d, step in enumerate(steps):
        stopped = 1 - transmittance[(d, *cells.T)]
        here = np.flatnonzero(stopped > 0)
        views = list(_views(shape, surfels, step, basis))
        weights = _winners([view.potential(step)[tuple(cells[here].T)] for view in views])
        for view, weight in zip(views, weights):
            all_of_it = view.at_faces(cells[here], step)[:, :1]
            # Where a view has no surfel it has lost, and its weight is zero.
            scale = (weight * stopped[here])[:, None] / np.where(all_of_it > 0, all_of_it, 1.0)
            for colour, part in enumerate(share.T):
                lobes[colour, here, d] += scale * view.scaled(part).at_faces(cells[here], step)
    return [without_idle_cells(cells, part) for part in lobes]


@dataclass(frozen=True, eq=False)
class _View:
    """One view of the geometry volume: where its nodes are, and surfels with their lobes.

    number: (*nodes), the row of a node, the last one for nodes without surfels. rows: (M,), of
    each surfel. lobes: (M, size), A_s h^{1−D} ⟨n_s|ω⟩₊.
    """

    number: Cells
    count: int
    rows: Cells
    lobes: Array
    basis: AngularBasis

    def scaled(self, factors: Array) -> _View:
        """With every surfel's lobe multiplied."""
        lobes = self.lobes * factors[:, None]
        return _View(self.number, self.count, self.rows, lobes, self.basis)

    @property
    def volume(self) -> Array:
        """Coefficients (nodes with surfels + 1, size); the last row is zero."""
        volume = np.zeros((self.count + 1, self.basis.size))
        np.add.at(volume, self.rows, self.lobes)
        return volume

    def potential(self, step: Cells) -> Array:
        """B(−d) at the face that light along an offset leaves each cell by, (*shape)."""
        towards = self.basis.evaluate(-step / np.linalg.norm(step))
        values = (self.volume @ towards)[self.number]
        shape = [n - 1 for n in values.shape]
        corners = _corners(step)
        faces = [values[tuple(slice(c, c + n) for c, n in zip(at, shape))] for at in corners]
        return np.asarray(sum(faces) / len(corners))

    def at_faces(self, cells: Cells, step: Cells) -> Array:
        """B at the faces by which light along an offset leaves cells (M, dimension), (M, size)."""
        volume, corners = self.volume, _corners(step)
        found = [volume[self.number[tuple((cells + at).T)]] for at in corners]
        return np.asarray(sum(found) / len(corners))


def _views(
    shape: tuple[int, ...], surfels: Surfels, step: Cells, basis: AngularBasis
) -> Iterator[_View]:
    """Closed surfaces from outside, and from inside if there are any; thin walls in both."""
    nodes = tuple(n + 1 for n in shape)
    flat = np.ravel_multi_index(tuple(surfels.nodes.T), nodes)
    used, rows = np.unique(flat, return_inverse=True)
    number = np.full(nodes, used.size)
    number.ravel()[used] = np.arange(used.size)
    for outside in (True, False) if surfels.closed.any() else (True,):
        lobes = surfels.areas[:, None] * _lobes(surfels, step, basis, outside)
        yield _View(number, used.size, rows.ravel(), lobes, basis)


def _lobes(surfels: Surfels, step: Cells, basis: AngularBasis, outside: bool) -> Array:
    """⟨n|ω⟩₊ of the side that light along an offset meets, (M, size); both halves if edge-on."""
    slope = surfels.normals @ (step / np.linalg.norm(step))
    turned = np.where(slope > 0, -1.0, 1.0)
    sign = np.where(surfels.closed, 1.0 if outside else -1.0, turned)
    lobes = basis.clamped_cosine(surfels.normals * sign[:, None])
    edge_on = ~surfels.closed & (np.abs(slope) < EDGE_ON)
    if edge_on.any():
        other = basis.clamped_cosine(-surfels.normals[edge_on] * sign[edge_on, None])
        lobes[edge_on] = 0.5 * (lobes[edge_on] + other)
    return lobes


def _winners(potentials: list[Array]) -> list[Array]:
    """Weight of each view: 1 for the larger potential, 1/2 where both are the same."""
    largest = np.max(potentials, axis=0)
    # Equal up to rounding: a wall seen edge-on has no preferred side.
    wins = [potential >= largest - EDGE_ON for potential in potentials]
    return [win / np.sum(wins, axis=0) for win in wins]


def _corners(step: Cells) -> list[tuple[int, ...]]:
    """Corners of the face, edge or corner of the unit cell that a step leads through."""
    ranges = [(0, 1) if s == 0 else ((1,) if s > 0 else (0,)) for s in step]
    return list(itertools.product(*ranges))
