"""Light of a field on surfaces (Kaplanyan & Dachsbacher 2010, 3.4; numerics §9).

Surfaces are points (M, dimension) [m] with unit normals that point away from them, towards the
side that is looked at: light falls on them along -n.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.harmonics import AngularBasis
from flatland.lookup import interpolate, lookup, places_in, unit_vectors

Array = NDArray[np.float64]
Method = Literal["distance", "cosine"]
METHODS: tuple[Method, ...] = get_args(Method)

__all__ = ["METHODS", "cosine_weights", "damping_factor", "interpolate", "irradiance"]

#: Gauss points of `cosine_weights`: per smooth piece in 2D, over the height in 3D.
_POINTS = {2: 16, 3: 64}


def irradiance(
    field: Field,
    points: ArrayLike,
    normals: ArrayLike,
    method: Method = "distance",
    damping: bool = False,
    offset: float = 0.0,
) -> Array:
    """Irradiance ([colours,] M) [W/m in 2D, W/m² in 3D], at least 0, where the field is looked up.

    distance: E = I(-n) / (h/2)^(dimension - 1), the paper's: all light comes straight down from
    half a cell away. In a uniform field of radiance L that is 2L(|n_x| + |n_y|) in 2D, right on
    axis-aligned surfaces and up to √2 too much on others; in 3D 4L(|n_x| + |n_y| + |n_z|) for πL.
    cosine: E = ∫ L ⟨-n|ω⟩₊ dω of the radiance that a uniform field of this intensity would have,
    see `cosine_weights`: 2L and πL on every surface, up to the truncation to n bands.
    damping: multiply by the `damping_factor`.
    offset: look up this many cells away from the surface along its normal. At 0, as the paper
    says, half the weight can lie on cells behind the surface; 0.5 keeps to those before it.
    normals: (M, dimension), or one for all.

    What it gets wrong besides: light and shadow are blurred over two cells, and negative lobes of
    truncated intensities are taken as darkness.
    """
    if method not in METHODS:
        raise bad_input("method", method, "is no way to light a surface", METHODS)
    places = places_in(field, points)
    unit = unit_vectors(field, normals, len(places), "normals")
    weights = _weights(field, unit, method)
    light = lookup(field, places + offset * field.grid.spacing * unit)
    result = np.maximum(0.0, np.einsum("...mk,mk->...m", light, weights))
    return np.asarray(result * damping_factor(field, places, unit) if damping else result)


def damping_factor(field: Field, points: ArrayLike, normals: ArrayLike) -> Array:
    """Factor in [0, 1], ([colours,] M), against light that leaks through surfaces (CLPV 3.4).

    f = 1 - min(1, ‖d‖/‖c‖) (1 - cos(c, d))/2 with the coefficients c at the point and their
    difference along the normal, d = c(x + n h/2) - c(x - n h/2). The paper dampens where the
    derivative "is large, and c and ∇c are deviating" and gives no formula; this one is ours.
    Light that is brighter, and alike, before the surface stays; light from behind goes.
    What it gets wrong: it dampens as much where light truly fades away from a surface.
    """
    places = places_in(field, points)
    unit = unit_vectors(field, normals, len(places), "normals")
    step = 0.5 * field.grid.spacing * unit
    light = lookup(field, places)
    change = lookup(field, places + step) - lookup(field, places - step)
    size, large = np.linalg.norm(light, axis=-1), np.linalg.norm(change, axis=-1)
    both = size * large
    alike = np.sum(light * change, axis=-1) / np.where(both > 0, both, 1.0)
    ratio = np.minimum(1.0, large / np.where(size > 0, size, 1.0))
    return np.asarray(np.clip(1 - ratio * (1 - alike) / 2, 0.0, 1.0))


def cosine_weights(basis: AngularBasis, normal: ArrayLike) -> Array:
    """∫ y(ω) ⟨-n|ω⟩₊ / Σ|ω_i| dω, (size,): coefficients times it over h^(dimension - 1) are E.

    A uniform field of radiance L leaves a cell with the intensity L h^(dimension - 1) Σ|ω_i|, its
    cross-section (numerics §1): h(|cos θ| + |sin θ|) L in 2D. Good to rounding in 2D, where the
    rule ends at every kink, and to about 1e-4 in 3D.
    """
    down = -np.asarray(normal, float)
    directions, weights = (_half_circle if basis.dimension == 2 else _half_sphere)(down)
    cosine = np.maximum(0.0, directions @ down)
    return np.asarray(
        (weights * cosine / np.abs(directions).sum(axis=1)) @ basis.evaluate(directions)
    )


def _weights(field: Field, normals: Array, method: Method) -> Array:
    """What the coefficients are multiplied with, (M, size)."""
    size = field.grid.spacing ** (field.grid.dimension - 1)
    if method == "distance":
        return field.basis.evaluate(-normals) * (2 ** (field.grid.dimension - 1) / size)
    kinds, places = np.unique(normals, axis=0, return_inverse=True)
    weights = [cosine_weights(field.basis, normal) for normal in kinds]
    return np.array(weights).reshape(-1, field.basis.size)[places.reshape(-1)] / size


def _half_circle(axis: Array) -> tuple[Array, Array]:
    """Gauss rule for directions less than a quarter turn from the axis, piece by piece.

    The axes' directions bound pieces: there cross-sections have kinks.
    """
    middle = np.arctan2(axis[1], axis[0])
    start, stop = middle - np.pi / 2, middle + np.pi / 2
    kinks = np.arange(-4, 5) * (np.pi / 2)
    ends = np.array([start, *kinks[(kinks > start) & (kinks < stop)], stop])
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS[2])
    half, centre = np.diff(ends)[:, None] / 2, (ends[1:] + ends[:-1])[:, None] / 2
    angles = (centre + half * nodes).ravel()
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1), (half * weights).ravel()


def _half_sphere(axis: Array) -> tuple[Array, Array]:
    """Product rule for directions less than a quarter turn from the axis."""
    count = _POINTS[3]
    nodes, weights = np.polynomial.legendre.leggauss(count)
    height = (nodes + 1) / 2
    azimuth = (np.arange(2 * count) + 0.5) * (np.pi / count)
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    around = np.cos(azimuth)[:, None] * first + np.sin(azimuth)[:, None] * second
    radius = np.sqrt(1 - height**2)[:, None, None]
    directions = (radius * around + height[:, None, None] * axis).reshape(-1, 3)
    return directions, np.repeat(weights / 2 * (np.pi / count), 2 * count)
