"""A homogeneous medium: what it does to a flight, and where a step puts its collisions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input

Array = NDArray[np.float64]

#: Optical length of a step beyond which nothing passes that a number could hold.
OPAQUE = 600.0
#: Where a collision on the way from cell to cell is put, see `share_ahead`.
SHARES = ("moment", "linear", "half", "ahead")
#: Optical length below which the closed forms of the share lose digits, and their series: of the
#: next term 2e-14 is left there.
_THIN = 0.2
_SERIES = {
    "moment": [
        1 / 2, -1 / 6, 0, 7 / 720, 0, -53 / 60480, 0, 313 / 3628800, 0, -1039 / 119750400,
    ],
    "linear": [1 / 2, -1 / 12, 0, 1 / 720, 0, -1 / 30240, 0, 1 / 1209600, 0, -1 / 47900160],
}  # fmt: skip


@dataclass(frozen=True)
class Medium:
    """A medium that fills the grid.

    extinction: collisions per metre of flight, σ_t [1/m], above 0. albedo: share c of the light of
    a collision that is scattered, the same in all directions; the rest is absorbed.
    """

    extinction: float
    albedo: float

    def optical_lengths(self, offsets: ArrayLike, spacing: float) -> Array:
        """σ_t |d| h of steps (K, dimension) between cell centres, (K,)."""
        lengths = np.linalg.norm(np.asarray(offsets, float), axis=-1)
        return np.asarray(self.extinction * spacing * lengths)

    def require_passable(self, longest: float) -> None:
        """Raise InputError if nothing that a number could hold passes an optical length."""
        if longest > OPAQUE:
            rule = f"leaves e^-{longest:.0f} of the light after one step; at most {OPAQUE:g}"
            raise bad_input("medium, extinction", self.extinction, rule)


def collision_probability(optical_length: ArrayLike) -> Array:
    """1 - e^-x."""
    return np.asarray(-np.expm1(-np.asarray(optical_length, float)))


def share_ahead(optical_length: ArrayLike, rule: str = "moment") -> Array:
    """Of the light that collides on a step of optical length x, the share put at its end.

    The rest is put at its beginning. "moment": b = 1 - ((2 - p)/p² - 2/x²) / (2/p - 1) with
    p = 1 - e^-x. A flight of k whole steps then ends at k x with the weight of b or at (k - 1) x,
    and its mean square is that of exponential flights, 2/x²: the mean square distance that
    light travels, and with it the diffusion coefficient, come out exact. "linear": b = 1/x - (1 -
    p)/p, the exact mean position, x²/12 too much in the mean square. "half", and "ahead", all at
    the end: the obvious ones. "moment" and "linear" tend to 1/2 in a thin medium.
    Raises InputError for an unknown rule.
    """
    if rule not in SHARES:
        raise bad_input("share", rule, "is unknown", SHARES)
    x = np.asarray(optical_length, float)
    if rule in ("half", "ahead"):
        return np.full(x.shape, 0.5 if rule == "half" else 1.0)
    thick = np.maximum(x, _THIN)
    p = collision_probability(thick)
    if rule == "moment":
        closed = 1 - ((2 - p) / p**2 - 2 / thick**2) / (2 / p - 1)
    else:
        closed = 1 / thick - (1 - p) / p
    return np.asarray(np.where(x < _THIN, np.polynomial.Polynomial(_SERIES[rule])(x), closed))
