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


def element_of_one(quantity: str) -> Option:
    """How finely walls that reflect are cut: each piece has one `quantity`."""
    return Option(
        "element",
        float,
        0.5,
        f"longest piece of a reflecting wall with one {quantity}, in cells",
        minimum=0.01,
        maximum=1000.0,
    )


ELEMENT = element_of_one("radiance")
BOUNCES = Option(
    "bounces", bool, True, "walls send light back as their albedo says; else all black"
)
