"""Where the light goes: flux onto walls and out of the grid, by crossed strings alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.ledger import Ledger
from propagators.analytic.blockers import TOUCH
from propagators.analytic.geometry import Geometry
from propagators.analytic.points import collect_point_light
from propagators.analytic.targets import collect_light

Array = NDArray[np.float64]


def absorbed_flux(geometry: Geometry) -> Array:
    """Flux (surfaces, C) that each emitter, then each segment of the scene absorbs [W].

    Where two lie on one another, the earlier one gets the light.
    """
    pieces, owners = [], []
    for k, wall in enumerate(geometry.walls):
        found = uncovered(wall, geometry.walls[:k])
        pieces += [*found, *found[:, [2, 3, 0, 1]]]
        owners += 2 * len(found) * [geometry.surfaces[k]]
    flux = arriving_flux(geometry, np.array(pieces).reshape(-1, 4), geometry.walls)
    surfaces = len(geometry.emitters) + geometry.segment_count
    result = np.zeros((surfaces, flux.shape[1]))
    np.add.at(result, np.array(owners, np.int64), flux)
    return result


def balance(geometry: Geometry, coloured: bool) -> Ledger:
    """The books of a scene, entries (C,), or () for a grey one.

    left: what crosses the border outwards, except where a wall lies on it. Lights must shine into
    the grid, as every scene's do.
    """
    emitted = 2 * _lengths(geometry.emitters) @ geometry.radiance + _point_flux(geometry)
    open_border = [piece for side in geometry.border for piece in uncovered(side, geometry.walls)]
    outwards = arriving_flux(geometry, np.array(open_border).reshape(-1, 4), geometry.walls)
    absorbed = absorbed_flux(geometry).sum(axis=0)
    entries = emitted, outwards.sum(axis=0), absorbed
    return Ledger(*(entry if coloured else entry[0] for entry in entries))


def arriving_flux(geometry: Geometry, targets: Array, walls: Array) -> Array:
    """Flux (K, C) that arrives on the left of targets (K, 4) past the walls (S, 4)."""
    groups = np.ascontiguousarray(targets[:, None])  # one memory layout, one compilation
    lights, radiance = geometry.emitters, geometry.radiance
    flux = collect_light(groups, lights, radiance, walls, 1)[:, :, 0]
    if len(geometry.positions):
        points = geometry.positions, geometry.series, geometry.lobes, geometry.spectra
        flux += collect_point_light(groups, *points, walls, 1)[:, :, 0]
    return flux


def uncovered(segment: Array, others: Array) -> Array:
    """The parts (K, 4) of a segment (4,) that no other (M, 4) lies on."""
    start, extent = segment[:2], segment[2:] - segment[:2]
    length = np.hypot(*extent)
    ends = others.reshape(-1, 2, 2) - start
    distance = np.abs(ends @ [-extent[1], extent[0]]) / length
    places = np.sort(ends @ extent / length**2, axis=1)[np.all(distance <= TOUCH, axis=1)]
    parts, reached = [], 0.0
    for first, last in [*sorted(places.tolist()), [1.0, 1.0]]:
        if min(first, 1.0) - reached > TOUCH / length:
            parts.append([reached, min(first, 1.0)])
        reached = max(reached, last)
    cuts = np.array(parts).reshape(-1, 2, 1)
    return (start + cuts * extent).reshape(-1, 4)


def _lengths(segments: Array) -> Array:
    return np.hypot(*(segments[:, 2:] - segments[:, :2]).T)


def _point_flux(geometry: Geometry) -> Array:
    unit = np.sqrt(2 * np.pi) * geometry.series[:, 0] + geometry.lobes[:, 0]
    return unit @ geometry.spectra
