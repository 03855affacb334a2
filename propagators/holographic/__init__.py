"""Holographic radiance cascades."""

from propagators.holographic.propagator import HolographicCascades

__all__ = ["HolographicCascades"]
