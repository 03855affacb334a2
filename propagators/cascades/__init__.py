"""Radiance cascades: light gathered by ever fewer probes that look ever farther and finer."""

from propagators.cascades.propagator import RadianceCascades

__all__ = ["RadianceCascades"]
