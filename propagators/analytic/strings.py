"""Crossed strings with harmonics: the closed form behind the analytic reference.

A target segment is described in its own frame: t runs along it, d is the distance on the side
that the light comes from, and the light leaves along the normal -d. From the target's point t a
point V = (t_V, d_V) is seen by a string of length ρ; the light that comes along it travels at
the angle φ = atan2(t - t_V, d_V) from that normal. If the points seen between the edges V and W
(V at the smaller t) are lit with radiance 1, the light that arrives on t0 <= t <= t1 is

    ∫dt ∫dφ cos φ e^{imφ} = S(t1, V) - S(t0, V) - S(t1, W) + S(t0, W)
    S_m = ρ e^{imφ} / (1 - m²),    S_1 = -(i/2) ρ φ e^{iφ}

because dS_m/dt is an antiderivative of cos φ e^{imφ} in φ, up to a constant. Band 0 is Hottel's
rule of crossed strings (Radiant Heat Transmission, 1954): uncrossed lengths minus crossed ones.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner

Vector = NDArray[np.float64]

#: Gauss-Legendre nodes and weights on [0, 1]; four leave 1e-15 under the condition in `add_beam`.
_NODES = tuple((0.5 + 0.5 * np.polynomial.legendre.leggauss(4)[0]).tolist())
_WEIGHTS = tuple((0.5 * np.polynomial.legendre.leggauss(4)[1]).tolist())


@inner
def add_string(moments: Vector, weight: float, along: float, distance: float) -> None:
    """moments (2 bands - 1,) += weight S; along: t - t_V, distance: d_V.

    moments holds the real part of band 0, then real and imaginary part of m = 1 … bands - 1.
    """
    length = math.sqrt(along * along + distance * distance)
    moments[0] += weight * length
    if moments.size == 1 or length == 0.0:
        return
    angle = math.atan2(along, distance)
    moments[1] += weight * 0.5 * along * angle
    moments[2] -= weight * 0.5 * distance * angle
    cosine, sine = distance / length, along / length
    real, imaginary = weight * distance, weight * along
    for m in range(2, moments.size // 2 + 1):
        real, imaginary = real * cosine - imaginary * sine, real * sine + imaginary * cosine
        scale = 1.0 / (1.0 - m * m)
        moments[2 * m - 1] += scale * real
        moments[2 * m] += scale * imaginary


@inner
def add_string_slope(
    moments: Vector, weight: float, along: float, distance: float, step_t: float, step_d: float
) -> None:
    """moments (2 bands - 1,) += weight dS/dλ for an edge that moves as V + λ (step_t, step_d)."""
    length = math.sqrt(along * along + distance * distance)
    if length == 0.0:
        return
    cosine, sine = distance / length, along / length
    stretch, turn = step_d * cosine - step_t * sine, -step_t * cosine - step_d * sine
    moments[0] += weight * stretch
    if moments.size == 1:
        return
    # dS_1 = -(i/2) (φ dr + r dφ) with r = d_V + i (t - t_V) and r dφ = turn e^{iφ}.
    angle = math.atan2(along, distance)
    moments[1] += weight * 0.5 * (sine * turn - step_t * angle)
    moments[2] -= weight * 0.5 * (cosine * turn + step_d * angle)
    power_real, power_imaginary = weight * cosine, weight * sine
    for m in range(2, moments.size // 2 + 1):
        power_real, power_imaginary = (
            power_real * cosine - power_imaginary * sine,
            power_real * sine + power_imaginary * cosine,
        )
        scale = 1.0 / (1.0 - m * m)
        moments[2 * m - 1] += scale * (power_real * stretch - power_imaginary * m * turn)
        moments[2 * m] += scale * (power_imaginary * stretch + power_real * m * turn)


@inner
def add_beam(
    moments: Vector, t0: float, t1: float, low_t: float, low_d: float, high_t: float, high_d: float
) -> None:
    """moments += the light seen between the edges `low` and `high` that arrives on [t0, t1].

    Four strings of length ρ cancel to their length times rounding. What a light or a stretch of
    the target of size w << ρ has to do with one another is only w/ρ of that, so the difference
    over w is integrated from its slope instead.
    """
    step_t, step_d = high_t - low_t, high_d - low_d
    width, narrow = t1 - t0, 0.04 / (moments.size // 2 + 2) ** 2
    near_low = (min(max(low_t, t0), t1) - low_t) ** 2 + low_d * low_d
    near_high = (min(max(high_t, t0), t1) - high_t) ** 2 + high_d * high_d
    if step_t * step_t + step_d * step_d < narrow * near_low:
        for k in range(4):
            t, d = low_t + _NODES[k] * step_t, low_d + _NODES[k] * step_d
            add_string_slope(moments, -_WEIGHTS[k], t1 - t, d, step_t, step_d)
            add_string_slope(moments, _WEIGHTS[k], t0 - t, d, step_t, step_d)
    elif width * width < narrow * min(near_low, near_high):
        for k in range(4):
            t = t0 + _NODES[k] * width
            add_string_slope(moments, _WEIGHTS[k], t - low_t, low_d, -width, 0.0)
            add_string_slope(moments, -_WEIGHTS[k], t - high_t, high_d, -width, 0.0)
    else:
        add_string(moments, 1.0, t1 - low_t, low_d)
        add_string(moments, -1.0, t0 - low_t, low_d)
        add_string(moments, -1.0, t1 - high_t, high_d)
        add_string(moments, 1.0, t0 - high_t, high_d)


@inner
def turn_moments(moments: Vector, cosine: float, sine: float) -> None:
    """From angles against a normal at (cosine, sine) to angles against +x: times normal^m."""
    power_real, power_imaginary = 1.0, 0.0
    for m in range(1, moments.size // 2 + 1):
        power_real, power_imaginary = (
            power_real * cosine - power_imaginary * sine,
            power_real * sine + power_imaginary * cosine,
        )
        real, imaginary = moments[2 * m - 1], moments[2 * m]
        moments[2 * m - 1] = real * power_real - imaginary * power_imaginary
        moments[2 * m] = real * power_imaginary + imaginary * power_real
