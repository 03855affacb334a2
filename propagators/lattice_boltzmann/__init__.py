"""Lattice-Boltzmann lighting."""

from propagators.lattice_boltzmann.propagator import LatticeBoltzmann

__all__ = ["LatticeBoltzmann"]
