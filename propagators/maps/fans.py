"""The directions of light propagation maps: four maps of M equal angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics
from propagators.maps.rays import Fan

Array = NDArray[np.float64]

#: The golden ratio's fraction: offsets of rays that repeat as late as possible.
_GOLDEN = 0.6180339887498949


def make_fan(angles: int, rays: int, basis: CircularHarmonics) -> Fan:
    """`angles` bins of width π/(2M) over ±45° round each axis, `rays` for each cell across.

    A ray of radiance L carries L (sin b - sin a) / rays, [a, b] its bin seen from the axis, and in
    it the mean of y weighted by the cosine: just what the outflow through a face wants.
    """
    edges = np.linspace(-np.pi / 4, np.pi / 4, angles + 1)
    axes = np.arange(4) * np.pi / 2
    middle = (0.5 * (edges[:-1] + edges[1:]) + axes[:, None]).ravel()
    widths = np.tile(np.sin(edges[1:]) - np.sin(edges[:-1]), 4)
    means, arcs = [], []
    for axis in axes:
        means.append(basis.cosine_arc_integral(edges[:-1] + axis, edges[1:] + axis, axis))
        arcs.append(basis.arc_integral(edges[:-1] + axis, edges[1:] + axis))
    offsets = (_GOLDEN * np.arange(angles) + 0.25 * np.arange(4)[:, None]) % 1.0
    directions = np.stack([np.cos(middle), np.sin(middle)], axis=-1)
    directions[np.abs(directions) < 1e-15] = 0.0  # along an axis, if M is odd
    return Fan(
        directions,
        offsets.ravel(),
        widths / rays,
        np.concatenate(means) / widths[:, None],
        np.concatenate(arcs),
        rays,
    )
