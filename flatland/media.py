"""Single scattering in a thin homogeneous medium, by marching along view rays.

Kaplanyan & Dachsbacher 2010, section 7, march through the propagated light and add up what an
isotropic medium scatters towards the eye, in steps of one cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.lookup import lookup, places_in, unit_vectors
from flatland.radiance import radiance_matrix
from flatland.rays import free_lengths
from flatland.sources import Wall

Array = NDArray[np.float64]


class Scattered(NamedTuple):
    """What a medium does to view rays (M,).

    radiance: ([colours,] M), scattered towards the eye. transmittance: (M,), share of what comes
    from the end of the ray. lengths: (M,) [m], up to the first wall or the border.
    """

    radiance: Array
    transmittance: Array
    lengths: Array


def single_scattering(
    field: Field,
    origins: ArrayLike,
    directions: ArrayLike,
    scattering: float,
    absorption: float = 0.0,
    anisotropy: float = 0.0,
    walls: Sequence[Wall] = (),
    step: float = 1.0,
) -> Scattered:
    """L = ∫₀ˢ e^(-σt) σ_s ∫ p(ω·d') L(x + t d, ω) dω dt, d' = -d the way to the eye.

    origins: eyes (M, dimension) [m], in the grid. directions: unit vectors d from the eye, (M,
    dimension), or one for all. scattering, absorption: σ_s and σ_a [1/m], σ their sum. anisotropy:
    g, the mean cosine of the Henyey–Greenstein phase function p, which is isotropic for 0; it
    multiplies band l of the radiance by g^l, in 2D (where p is the Poisson kernel) as in 3D.
    step: length of a step in cells, at most; every ray is cut in equal steps.

    The source is looked up in the middle of each step, and the exponential integrated exactly: a
    uniform field of radiance L gives L σ_s/σ (1 - e^(-σs)) in one step or many, any other an error
    of the second order in the step, down to what the interpolated field can tell.
    The field's intensities become radiances as in flatland.radiance.

    What it gets wrong. The medium changes no light on its way to where it is scattered, as if it
    were thin there: the scattered light is added energy (the paper says so too) unless σ was part
    of the propagation. Light is scattered once. Bands of p beyond those of the field are left
    out, g^n of it and less. Negative lobes of truncated fields count as they are.
    """
    _check(scattering, absorption, anisotropy, step)
    places = places_in(field, origins)
    rays = unit_vectors(field, directions, len(places), "directions")
    lengths = free_lengths(field.grid, walls, places, rays)
    steps = np.maximum(1, np.ceil(lengths / (step * field.grid.spacing) - 1e-9)).astype(int)
    weights = scattering * _phase_weights(field, -rays, anisotropy)
    extinction = scattering + absorption
    size = lengths / steps
    once = size if extinction == 0 else -np.expm1(-extinction * size) / extinction
    total = np.zeros((*field.values.shape[: -field.grid.dimension - 1], len(places)))
    for number in range(steps.max(initial=0)):
        on = np.flatnonzero(number < steps)
        middle = (number + 0.5) * size[on]
        light = lookup(field, places[on] + middle[:, None] * rays[on])
        source = np.einsum("...mk,mk->...m", light, weights[on])
        total[..., on] += np.exp(-extinction * number * size[on]) * once[on] * source
    return Scattered(total, np.exp(-extinction * lengths), lengths)


def _phase_weights(field: Field, ways: Array, anisotropy: float) -> Array:
    """Weights (M, size) that make coefficients the radiance scattered along unit vectors, over σ_s.

    By Funk & Hecke a phase function of Legendre coefficients (2l + 1) g^l / 4π multiplies band l
    by g^l; on the circle it is the Poisson kernel that does.
    """
    basis, spacing = field.basis, field.grid.spacing
    towards = basis.evaluate(ways) * np.power(float(anisotropy), basis.degrees)
    return np.asarray(towards @ radiance_matrix(basis) / spacing ** (basis.dimension - 1))


def _check(scattering: float, absorption: float, anisotropy: float, step: float) -> None:
    for argument, value in (("scattering", scattering), ("absorption", absorption)):
        if not (np.isfinite(value) and value >= 0):
            raise bad_input(argument, value, "must be finite and at least 0")
    if not -1 < anisotropy < 1:
        raise bad_input("anisotropy", anisotropy, "must lie between -1 and 1")
    if not (np.isfinite(step) and step > 0):
        raise bad_input("step", step, "must be finite and greater than 0")
