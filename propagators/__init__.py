"""Propagation schemes, by name."""

from propagators.base import DirectPropagator, Option, Propagator, StencilPropagator
from propagators.registry import create, find, names

__all__ = [
    "DirectPropagator",
    "Option",
    "Propagator",
    "StencilPropagator",
    "create",
    "find",
    "names",
]
