"""The exact reference in two dimensions."""

from propagators.analytic.arcs import Arc
from propagators.analytic.propagator import Analytic

__all__ = ["Analytic", "Arc"]
