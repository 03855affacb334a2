"""The lattice: nine velocities, what a collision does to their populations, and what they carry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.harmonics import CircularHarmonics
from flatland.moments import Moments, moments_of

Array = NDArray[np.float64]

#: Rest, then 4 axial and 4 diagonal steps.
VELOCITIES = np.array(
    [(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)]
)
#: Shares of scattered light, none at rest: 4 to 1 is the only ratio whose fourth-order tensor is
#: isotropic, and what the 3D lattice, 1/12 and 1/24, projects to.
WEIGHTS = np.array([0, 1 / 5, 1 / 5, 1 / 5, 1 / 5, 1 / 20, 1 / 20, 1 / 20, 1 / 20])
#: Σ w c_x² = 3/5 doubles to the mean square length of a step, 6/5.
_MEAN_SQUARE = 6 / 5
#: σ_t h up to which a probability exists that gives the right mean square of flights.
THICKEST = float(np.sqrt(5 / 3))
#: How the probability of a collision in a step follows from σ_t h.
PROBABILITIES = ("calibrated", "linear", "exponential")
_DIRECTIONS = np.arctan2(VELOCITIES[1:, 1], VELOCITIES[1:, 0])


def collision_matrix(scattered: float, absorbed: float, reemits: bool) -> Array:
    """Θ (9, 9): share that goes from population j into i in a step (Geist et al. 2004).

    scattered, absorbed: s_s and s_a, probabilities of a step. Θ_ij = s_s w_i off the diagonal,
    1 - s_a - s_s + s_s w_i on it; s_a goes to rest. reemits: rest goes out again, Θ_i0 = w_i, as
    published: every column then sums to 1, and nothing is ever absorbed. Otherwise it is lost.
    """
    moving = scattered * np.tile(WEIGHTS[:, None], (1, 9))
    matrix = moving + (1 - absorbed - scattered) * np.eye(9)
    matrix[0] = absorbed
    matrix[:, 0] = WEIGHTS if reemits else 0.0
    return matrix


def step_probability(optical_length: float, rule: str = "calibrated") -> float:
    """Probability of a collision in a step of σ_t h.

    A flight of m ≥ 1 steps has E m² = (2 - p)/p², and steps the mean square 6/5: "calibrated"
    solves 6/5 (2 - p)/p² = 2/(σ_t h)², p = 4k/(√(k² + 8k) + k) with k = 0.6 (σ_t h)²; then light
    spreads over the exact mean square distance. "linear": σ_t h. "exponential": 1 - e^(-σ_t h).
    Raises InputError where p would exceed 1.
    """
    # With √k = r, so that nothing cancels or vanishes.
    root = np.sqrt(0.6) * optical_length
    values = {
        "calibrated": 4 * root / (np.hypot(root, np.sqrt(8)) + root),
        "linear": optical_length,
        "exponential": -np.expm1(-optical_length),
    }
    probability = float(values[rule])
    if probability > 1:
        limit = THICKEST if rule == "calibrated" else 1.0
        text = f"is too thick for this lattice: at most {limit:.3f} collisions a cell"
        raise bad_input("medium, extinction times spacing", optical_length, text)
    return probability


def arc_values(basis: CircularHarmonics) -> Array:
    """∫ y dω over the arc of each moving population, (8, size).

    Arcs are 2π w wide, 72° round the axes and 18° round the diagonals, so that the same intensity
    in all directions is the lattice's equilibrium.
    """
    half = np.pi * WEIGHTS[1:]
    return basis.arc_integral(_DIRECTIONS - half, _DIRECTIONS + half)


def lattice_moments(optical_length: float, albedo: float, rule: str = "calibrated") -> Moments:
    """Moments of collisions of an isotropic pulse in an endless medium, see `flatland.moments`."""
    p = step_probability(optical_length, rule)
    matrix = collision_matrix(albedo * p, (1 - albedo) * p, False)

    def response(waves: NDArray[np.complex128]) -> NDArray[np.complex128]:
        moved = np.exp(-1j * (waves @ VELOCITIES.T))
        system = np.eye(9) - matrix * moved[:, None, :]
        start = np.tile(WEIGHTS.astype(complex)[:, None], (len(waves), 1, 1))
        sent = np.linalg.solve(system, start)[:, :, 0]
        return np.asarray(p * np.sum(moved[:, 1:] * sent[:, 1:], axis=1))

    return moments_of(response, 0.1 * (1 - albedo) * optical_length)


def diffusion_coefficient(
    scattered: float, absorbed: float = 0.0, reemits: bool = True, direction: float = 0.0
) -> float:
    """D in cells² per step, from the slowest wave of |k| = 1e-3: (3/5)(1/s - 1/2) without
    absorption."""
    size = 1e-3
    wave = size * np.array([np.cos(direction), np.sin(direction)])
    step = collision_matrix(scattered, absorbed, reemits) * np.exp(-1j * (VELOCITIES @ wave))
    largest = np.abs(np.linalg.eigvals(step)).max()
    return float(-np.log(largest) / size**2)
