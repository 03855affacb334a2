"""Options that several propagators share."""

from __future__ import annotations

from propagators.base import Option

PROPAGATION_FACTOR = Option(
    "propagation_factor",
    float,
    1.0,
    "multiplies the light of every step (the octree thesis' p)",
    minimum=0.0,
    maximum=10.0,
)
