"""Light of reflecting walls through cells, by lines."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import SphericalHarmonics
from propagators.analytic_3d.directions import Beams, along, turned
from propagators.analytic_3d.radiosity import DENSITY, Bounced
from propagators.analytic_3d.traces import carried_light

Array = NDArray[np.float64]

#: Bytes of intensities held at once, and lines per cell side for single directions.
_ROOM, _FINE = 2**26, 8.0


def cell_light(
    bounced: Bounced,
    shape: tuple[int, ...],
    bands: int,
    beams: Beams,
    report: Callable[[float], object],
) -> Array:
    """Coefficients (cells, C, size) of what walls send through cells.

    In every direction, a cell's intensity is what a uniform field would give, |ω_x| + |ω_y| +
    |ω_z|, times the mean radiance of the lines that leave it: how many happen to do so does not
    matter. Directions integrate that of a uniform field exactly too.
    """
    basis, colours = SphericalHarmonics(bands), bounced.radiosity.shape[1]
    weight, parity = 2 * np.pi / len(beams.directions), (-1.0) ** basis.degrees
    cells = int(np.prod(shape))
    result, uniform = np.zeros((basis.size, cells, colours)), np.zeros(basis.size)
    batch = max(1, _ROOM // (8 * cells * (2 * colours + 1)))
    for start in range(0, len(beams.directions), batch):
        part = beams.part(start, start + batch)
        forward, backward = _radiance(bounced, shape, part, DENSITY)
        extent = np.abs(part.directions).sum(axis=1)
        values = weight * extent[:, None] * basis.evaluate(part.directions)
        uniform += (values * (1 + parity)).sum(axis=0)
        result += np.tensordot(values, forward, (0, 0))
        result += np.tensordot(values * parity, backward, (0, 0))
        report(min(1.0, (start + batch) / len(beams.directions)))
    exact = basis.clamped_cosine(np.concatenate([np.eye(3), -np.eye(3)])).sum(axis=0)
    result += (exact - uniform)[:, None, None] * (result[0] / uniform[0])
    return np.ascontiguousarray(result.transpose(1, 2, 0))


def cell_intensity(bounced: Bounced, shape: tuple[int, ...], directions: Array) -> Array:
    """Intensity (K, C, cells) of what walls send along directions (K, 3)."""
    cells, colours = int(np.prod(shape)), bounced.radiosity.shape[1]
    result = np.empty((len(directions), colours, cells))
    beams, back = along(directions, np.array([0.5, 0.5])), turned(directions)
    extent = np.abs(directions).sum(axis=1)
    batch = max(1, _ROOM // (8 * cells * (2 * colours + 1)))
    for start in range(0, len(directions), batch):
        some = slice(start, start + batch)
        forward, backward = _radiance(bounced, shape, beams.part(start, start + batch), _FINE)
        mean = np.where(back[some, None, None], backward, forward)
        result[some] = (extent[some, None, None] * mean).transpose(0, 2, 1)
    return result


def _radiance(
    bounced: Bounced, shape: tuple[int, ...], beams: Beams, density: float
) -> tuple[Array, Array]:
    """Mean radiance (M, cells, C) of the lines that leave each cell along directions, and against.

    A cell that no line leaves is dark.
    """
    radiance = bounced.radiosity / np.pi
    sums = carried_light(*beams, density, bounced.elements.rasters, radiance, shape)
    colours = radiance.shape[1]
    lines = np.where(sums[..., -1:] > 0, sums[..., -1:], 1.0)
    return sums[..., :colours] / lines, sums[..., colours:-1] / lines
