"""Discrete ordinates: transfer from centre to centre, one bin of directions per neighbour."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil
from propagators.base import Option, StencilPropagator
from propagators.directions import ALL_2D, AXIAL_2D, Array, circular, equal_arcs, unit
from propagators.options import PROPAGATION_FACTOR


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

    offsets: ClassVar[NDArray[np.int64]]
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
        starts, stops = equal_arcs(self.offsets)
        transfer = np.array([self._bin(basis, *bin_) for bin_ in zip(self.offsets, starts, stops)])
        stencil = Stencil(basis, self.offsets, transfer)
        return stencil.scaled(self.values["propagation_factor"])

    def _bin(self, basis: AngularBasis, offset: Array, start: float, stop: float) -> Array:
        circle = circular(basis)
        direction = basis.evaluate(unit(offset))
        integral = circle.arc_integral(start, stop)
        exact, delta = self.values["flux"] == "transfer", self.values["emission"] == "delta"
        if exact and not delta:
            return circle.arc_gram(start, stop)
        received = integral if exact else (stop - start) * direction
        emitted = direction if delta else integral / (stop - start)
        return np.outer(emitted, received)


class DiscreteOrdinates4(DiscreteOrdinates):
    """Four axial neighbours, bins of 90°.

    What it gets wrong: light moves along the axes only, and shows as bright crosses (ray
    effects) the more bands there are. With emission="delta" it grows by 1.2732 a step from 3 bands.
    """

    name = "dom4"
    summary = "discrete ordinates to the 4 axial neighbours"
    offsets = AXIAL_2D


class DiscreteOrdinates8(DiscreteOrdinates):
    """Eight neighbours, bins of 45°.

    What it gets wrong: eight streets of light (ray effects); between them it is dark. A diagonal
    step is longer, but counts as one cell: the scalar field is anisotropic even when isotropic
    light enters. With emission="delta" it grows by 1.2732 a step from 5 bands.
    """

    name = "dom8"
    summary = "discrete ordinates to all 8 neighbours"
    offsets = ALL_2D
