"""Discrete ordinates with exact beams."""

from propagators.beam.propagator import Beam

__all__ = ["Beam"]
