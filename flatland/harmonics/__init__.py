"""Angular bases: how a cell stores a function of direction."""

from flatland.harmonics.base import AngularBasis, basis_for
from flatland.harmonics.circular import CircularHarmonics
from flatland.harmonics.spherical import SphericalHarmonics

__all__ = ["AngularBasis", "CircularHarmonics", "SphericalHarmonics", "basis_for"]
