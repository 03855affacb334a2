"""How much of the light that leaves a cell its way to a neighbour lets through."""

from flatland.blocking.exact import exact_transmittance

__all__ = ["exact_transmittance"]
