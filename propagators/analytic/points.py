"""Light of point sources through targets: harmonics times harmonics over the arcs they subtend."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import make_scratch
from propagators.analytic.compiling import inner, share_work, shared
from propagators.analytic.views import add_view

Vector = NDArray[np.float64]


def collect_point_light(
    targets: Vector,
    positions: Vector,
    series: Vector,
    lobes: Vector,
    spectra: Vector,
    walls: Vector,
    bands: int,
) -> Vector:
    """Moments (G, C, 2 bands - 1) of point light through groups of targets (G, P, 4).

    ∫ I(ω) e^{imθ} dω over the directions in which a source sees a target from its left.
    positions (P, 2), series (P, K), lobes (P, 3), spectra (P, C): see `Geometry`.
    """
    result = np.zeros((len(targets), spectra.shape[1], 2 * bands - 1))
    share_work(_collect, len(targets), targets, positions, series, lobes, spectra, walls, result)
    return result


@shared
def _collect(
    party: int,
    parties: int,
    targets: Vector,
    positions: Vector,
    series: Vector,
    lobes: Vector,
    spectra: Vector,
    walls: Vector,
    result: Vector,
) -> None:
    work = make_scratch(walls.shape[0])
    size = result.shape[2]
    arcs, lobe_arcs = np.empty(size + series.shape[1] - 1), np.empty(size + 2)
    moments = np.empty(size)
    for g in range(party, targets.shape[0], parties):
        for s in range(positions.shape[0]):
            arcs.fill(0.0)
            lobe_arcs.fill(0.0)
            x, y = positions[s, 0], positions[s, 1]
            for p in range(targets.shape[1]):
                add_view(x, y, targets[g, p], walls, lobes[s], work, arcs, lobe_arcs)
            if arcs[0] == 0.0:
                continue
            moments.fill(0.0)
            _add_series(moments, arcs, series[s])
            if lobe_arcs[0] != 0.0:
                _add_lobe(moments, lobe_arcs, lobes[s])
            for colour in range(spectra.shape[1]):
                for k in range(size):
                    result[g, colour, k] += spectra[s, colour] * moments[k]


@inner
def _add_series(moments: Vector, arcs: Vector, series: Vector) -> None:
    """moments += ∫ Σ_k (a_k e^{ikθ} + conj) e^{imθ} = Σ_k a_k E_{m+k} + conj(a_k) E_{m-k}."""
    constant = series[0] / math.sqrt(2.0 * math.pi)
    for j in range(moments.size):
        moments[j] += constant * arcs[j]
    for k in range(1, series.size // 2 + 1):
        real, imaginary = series[2 * k - 1], -series[2 * k]
        if real != 0.0 or imaginary != 0.0:
            scale = 0.5 / math.sqrt(math.pi)
            _add_turned(moments, arcs, k, scale * real, scale * imaginary)


@inner
def _add_lobe(moments: Vector, arcs: Vector, lobe: Vector) -> None:
    """moments += Φ/2 ∫ cos(θ - θ₀) e^{imθ} dθ, where lobe is (Φ, cos θ₀, sin θ₀)."""
    _add_turned(moments, arcs, 1, 0.25 * lobe[0] * lobe[1], -0.25 * lobe[0] * lobe[2])


@inner
def _add_turned(moments: Vector, arcs: Vector, k: int, real: float, imaginary: float) -> None:
    """moments_m += a E_{m+k} + conj(a) E_{m-k} with a = real + i imaginary, E in arcs."""
    for m in range(moments.size // 2 + 1):
        up, down = m + k, m - k
        up_real, up_imaginary = arcs[2 * up - 1], arcs[2 * up]
        if down == 0:
            down_real, down_imaginary = arcs[0], 0.0
        else:
            # E_{-k} is the conjugate of E_k.
            down_real = arcs[2 * abs(down) - 1]
            down_imaginary = arcs[2 * abs(down)] if down > 0 else -arcs[2 * abs(down)]
        sum_real = real * (up_real + down_real) - imaginary * (up_imaginary - down_imaginary)
        if m == 0:
            moments[0] += sum_real
            continue
        moments[2 * m - 1] += sum_real
        moments[2 * m] += real * (up_imaginary + down_imaginary) + imaginary * (up_real - down_real)
