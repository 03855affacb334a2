"""Discrete ordinates: transfer from centre to centre, one bin of directions per neighbour."""

from __future__ import annotations

from typing import ClassVar

from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil
from propagators.base import Option, StencilPropagator
from propagators.directions import ALL_2D, ALL_3D, AXIAL_2D, AXIAL_3D, Array, Offsets, unit
from propagators.options import PROPAGATION_FACTOR
from propagators.regions import voronoi_cells


class DiscreteOrdinates(StencilPropagator):
    """Discrete ordinates on the lattice of neighbours (Chandrasekhar 1950; numerics §3).

    Direction space is split into one bin per neighbour, the Voronoi cells of the neighbour
    directions ω_d. emission="bin": the intensity restricted to the bin, re-projected,
    T_d = ∫_bin y yᵀ dω; never gains in the L2 norm, so it is stable for any number of bands.
    emission="delta": the bin's flux leaves along ω_d, T_d = y(ω_d) ⊗ ∫_bin y dω. flux="central"
    replaces the intensity in a bin by its value at ω_d.

    Kaplanyan & Dachsbacher 2010 compare with DOM4 and DOM8 in section 5 but print no formula:
    these definitions are this project's.
    """

    offsets: ClassVar[Offsets]
    options = (
        Option(
            "flux", str, "transfer", "flux of a bin: exact, or one sample", ("transfer", "central")
        ),
        Option(
            "emission",
            str,
            "bin",
            "what a neighbour stores: the intensity in the bin, or a peak along the step",
            ("bin", "delta"),
        ),
        PROPAGATION_FACTOR,
    )

    def _build(self, basis: AngularBasis) -> Stencil:
        stencil = Stencil(basis, self.offsets, self._transfer(basis))
        return stencil.scaled(self.values["propagation_factor"])

    def _transfer(self, basis: AngularBasis) -> Array:
        bins, directions = voronoi_cells(self.offsets), basis.evaluate(unit(self.offsets))
        exact, delta = self.values["flux"] == "transfer", self.values["emission"] == "delta"
        if exact and not delta:
            return bins.gram(basis)
        integral, angles = bins.integral(basis), bins.angles[:, None]
        received = integral if exact else angles * directions
        emitted = directions if delta else integral / angles
        return emitted[:, :, None] * received[:, None, :]


class DiscreteOrdinates4(DiscreteOrdinates):
    """Four axial neighbours, bins of 90° (numerics §3).

    What it gets wrong: light moves along the axes only, and shows as bright crosses (ray
    effects) the more bands there are. With emission="delta" it grows by 1.2732 a step from 3 bands.
    """

    name = "dom4"
    summary = "discrete ordinates to the 4 axial neighbours"
    offsets = AXIAL_2D


class DiscreteOrdinates8(DiscreteOrdinates):
    """Eight neighbours, bins of 45° (numerics §3).

    What it gets wrong: eight streets of light (ray effects); between them it is dark. A diagonal
    step is longer, but counts as one cell: the scalar field is anisotropic even when isotropic
    light enters. With emission="delta" it grows by 1.2732 a step from 5 bands.
    """

    name = "dom8"
    summary = "discrete ordinates to all 8 neighbours"
    offsets = ALL_2D


class DiscreteOrdinates6(DiscreteOrdinates):
    """Six axial neighbours in 3D, bins that are the faces of a cube seen from its centre.

    Each is 2π/3 sr (numerics §3).

    What it gets wrong: light moves along the axes only, so that a source draws six rays and a
    slanted beam a staircase. With emission="delta" light grows by 1.3783 a step from 3 bands.
    """

    name = "dom6"
    summary = "discrete ordinates to the 6 axial neighbours in 3D"
    dimensions = (3,)
    offsets = AXIAL_3D


class DiscreteOrdinates26(DiscreteOrdinates):
    """All 26 neighbours in 3D: octagonal, rectangular and hexagonal bins.

    The bins' solid angles are 0.5753 sr (axial steps), 0.4647 sr (two axes) and 0.4423 sr (three;
    numerics §3).

    What it gets wrong: 26 streets of light (ray effects). A diagonal step is up to √3 times as
    long, but counts as one: the front of a light is a cube. With emission="delta" light grows by
    1.3230 a step from 5 bands.
    """

    name = "dom26"
    summary = "discrete ordinates to all 26 neighbours in 3D"
    dimensions = (3,)
    offsets = ALL_3D
