"""How much of the light that leaves a cell its way to a neighbour lets through, and sends back."""

from flatland.blocking.exact import exact_transmittance
from flatland.blocking.fuzzy import fuzzy_reflection, fuzzy_transmittance
from flatland.blocking.mirrors import exact_reflection
from flatland.blocking.surfels import (
    Surfels,
    surfels_of,
    surfels_of_facets,
    surfels_of_segments,
)

__all__ = [
    "Surfels",
    "exact_reflection",
    "exact_transmittance",
    "fuzzy_reflection",
    "fuzzy_transmittance",
    "surfels_of",
    "surfels_of_facets",
    "surfels_of_segments",
]
