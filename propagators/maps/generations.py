"""Light that walls send back and a medium scatters, generation after generation, all at once."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.errors import SchemeWarning
from flatland.medium_step import WORST_SPREAD
from flatland.scene import Scene
from propagators.maps.flight import Maps
from propagators.maps.rays import Tally
from propagators.transport.settling import settled

Array = NDArray[np.float64]


class SettledLight(NamedTuple):
    """values: coefficients (C, size, nx, ny) of what leaves cells. sent: (E, 2, C), flux that walls

    send back. scattered: (C, nx, ny), flux that cells scatter. tally: of all light together.
    """

    values: Array
    sent: Array
    scattered: Array
    tally: Tally


def settled_light(
    maps: Maps,
    cells: Array | None,
    arrived: Array,
    collided: Array | None = None,
    lights: bool = True,
) -> SettledLight:
    """All light of a scene, or all that follows from a first flight that was done elsewhere.

    cells: coefficients (C, size, nx, ny) that cells send. arrived: (E, 2, C), flux on walls that is
    not of these rays. collided: (C, nx, ny), the same of the medium. lights: whether they shine.
    Raises ConvergenceError where light never ends.
    """
    problem = maps.problem
    _warn_of_spread(problem.scene)
    medium, shape = problem.scene.medium, (problem.colours, *problem.shape)
    albedo = 0.0 if medium is None else medium.albedo
    share = np.repeat(problem.surfaces.albedo[:, None], 2, axis=1)
    reflects = share > 0
    count = int(np.count_nonzero(reflects))

    def unpacked(vector: Array) -> tuple[Array, Array]:
        sent, scattered = np.zeros(share.shape), np.zeros(shape)
        sent[reflects] = vector[:count]
        if albedo > 0:
            scattered = vector[count:].reshape(shape)
        return sent, scattered

    def packed(on_walls: Array, in_cells: Array) -> Array:
        parts = [(share * on_walls)[reflects]]
        if albedo > 0:
            parts.append(albedo * in_cells.ravel())
        return np.concatenate(parts)

    def once(vector: Array) -> Array:
        sent, scattered = unpacked(vector)
        glow = _isotropic(scattered, 1) if albedo > 0 else None
        tally = maps.run(sent, glow, lights=False, deposit=False)
        return packed(tally.arrived, _by_colour(tally.collided))

    sent, scattered = np.zeros(share.shape), np.zeros(shape)
    if count or albedo > 0:
        first = maps.run(sent, cells, lights, deposit=False)
        met = _by_colour(first.collided) + (0.0 if collided is None else collided)
        sent, scattered = unpacked(settled(once, packed(first.arrived + arrived, met)))
    glow = cells
    if albedo > 0:
        glow = _isotropic(scattered, problem.basis.size) + (0.0 if cells is None else cells)
    tally = maps.run(sent, glow, lights)
    values = tally.cells.reshape(*problem.shape, problem.colours, -1).transpose(2, 3, 0, 1)
    return SettledLight(np.ascontiguousarray(values), sent, scattered, tally)


def _isotropic(flux: Array, size: int) -> Array:
    """Coefficients (C, size, nx, ny) of flux (C, nx, ny) in all directions alike."""
    result = np.zeros((flux.shape[0], size, *flux.shape[1:]))
    result[:, 0] = flux / np.sqrt(2 * np.pi)
    return result


def _by_colour(values: Array) -> Array:
    """(nx, ny, C) as (C, nx, ny)."""
    return np.moveaxis(values, 2, 0)


def _warn_of_spread(scene: Scene) -> None:
    """One SchemeWarning where scattering from whole cells spreads light too far.

    A flight starts and ends anywhere in a cell but is counted from middle to middle: by h²/6 each.
    """
    if scene.medium is None or scene.medium.albedo == 0:
        return
    optical = scene.medium.extinction * scene.grid.spacing
    excess = optical**2 / 6
    if excess > WORST_SPREAD:
        message = (
            f"in this medium, of {optical:.3g} collisions a cell, scattering from whole cells "
            f"spreads light over up to {1 + excess:.1%} of the mean square distance"
        )
        warnings.warn(message, SchemeWarning, stacklevel=5)
