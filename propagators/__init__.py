"""Propagation schemes, by name."""

from propagators.base import Option, Propagator, StencilPropagator
from propagators.registry import create, find, names

__all__ = ["Option", "Propagator", "StencilPropagator", "create", "find", "names"]
