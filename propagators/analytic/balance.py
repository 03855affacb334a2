"""Where the light goes: flux onto walls and out of the grid, by crossed strings alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.ledger import Ledger
from propagators.analytic.blockers import TOUCH
from propagators.analytic.geometry import Geometry
from propagators.analytic.lighting import collect_all
from propagators.analytic.overlaps import uncovered
from propagators.analytic.radiosity import Bounced

Array = NDArray[np.float64]


def absorbed_flux(geometry: Geometry, bounced: Bounced | None = None) -> Array:
    """Flux (surfaces, C) that each emitter, then each segment of the scene absorbs [W].

    A share 1 - albedo of what arrives. Where two lie on one another, the earlier one gets it.
    """
    pieces, owners = [], []
    for k, wall in enumerate(geometry.walls):
        found = uncovered(wall, geometry.walls[:k])
        # What arrives at the rear of a gate has come in through it.
        sides = [found] if geometry.gates[k] else [found, found[:, [2, 3, 0, 1]]]
        pieces += sides
        owners += len(sides) * len(found) * [geometry.surfaces[k]]
    flux = arriving_flux(geometry, np.concatenate([np.empty((0, 4)), *pieces]), bounced)
    result = np.zeros((len(geometry.albedo), flux.shape[1]))
    np.add.at(result, np.array(owners, np.int64), flux)
    return result * (1 - geometry.albedo)


def balance(geometry: Geometry, coloured: bool, bounced: Bounced | None = None) -> Ledger:
    """The books of a scene, entries (C,), or () for a grey one.

    emitted: by lights, and what parallel light brings over the border. left: what crosses the
    border outwards, and what walls on it send outwards. Lights must shine into the grid, as every
    scene's do.
    """
    emitted = 2 * _lengths(geometry.emitters) @ geometry.radiance + _point_flux(geometry)
    emitted = emitted + _parallel_flux(geometry)
    open_border = [piece for side in geometry.border for piece in uncovered(side, geometry.walls)]
    targets = np.array(open_border).reshape(-1, 4)
    left = arriving_flux(geometry, targets, bounced).sum(axis=0)
    if bounced is not None:
        left = left + _thrown_out(geometry, bounced)
    absorbed = absorbed_flux(geometry, bounced).sum(axis=0)
    return Ledger(*(entry if coloured else entry[0] for entry in (emitted, left, absorbed)))


def arriving_flux(geometry: Geometry, targets: Array, bounced: Bounced | None = None) -> Array:
    """Flux (K, C) that arrives on the left of targets (K, 4), past all walls."""
    groups = np.ascontiguousarray(targets[:, None])  # one memory layout, one compilation
    return collect_all(geometry, groups, 1, bounced)[:, :, 0]


def _lengths(segments: Array) -> Array:
    return np.hypot(*(segments[:, 2:] - segments[:, :2]).T)


def _point_flux(geometry: Geometry) -> Array:
    unit = np.sqrt(2 * np.pi) * geometry.series[:, 0] + geometry.lobes[:, 0]
    return unit @ geometry.spectra


def _parallel_flux(geometry: Geometry) -> Array:
    """What parallel light brings in: irradiance times the width of the grid across it."""
    width, height = geometry.grid.shape
    return np.abs(geometry.directions) @ [height, width] @ geometry.irradiances


def _thrown_out(geometry: Geometry, bounced: Bounced) -> Array:
    """Flux (C,) of elements on the border that face away from the grid."""
    outwards = np.zeros(len(bounced.elements.segments), bool)
    for side in geometry.border:
        normal = np.array([side[3] - side[1], side[0] - side[2]]) / np.hypot(*(side[2:] - side[:2]))
        ends = bounced.elements.segments.reshape(-1, 2, 2) - side[:2]
        along = bounced.elements.segments[:, 2:] - bounced.elements.segments[:, :2]
        on_side = np.all(np.abs(ends @ normal) <= TOUCH, axis=1)
        outwards |= on_side & (along @ (side[2:] - side[:2]) < 0)
    return bounced.elements.lengths[outwards] @ bounced.radiosity[outwards]
