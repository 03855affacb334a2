"""Discrete ordinates swept over the grid."""

from propagators.sn.propagator import GridSweeps

__all__ = ["GridSweeps"]
