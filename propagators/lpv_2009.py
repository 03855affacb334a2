"""The first light propagation volumes, of 2009: one lobe per neighbour."""

from __future__ import annotations

from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil
from propagators.base import StencilPropagator
from propagators.directions import AXIAL, unit
from propagators.options import PROPAGATION_FACTOR


class LightPropagationVolume2009(StencilPropagator):
    """LPV of the SIGGRAPH 2009 course (Kaplanyan 2009; the octree thesis 4.1; numerics §3).

    The intensity is evaluated only towards the neighbour, taken as constant over the angle Δω
    that the neighbour subtends, and re-emitted as one clamped-cosine lobe along the step:
    T_d = Δω lobe(d) ⊗ y(d), lobe of unit flux, Δω = π/2 in 2D and 2π/3 sr in 3D.

    What it gets wrong: one sample per neighbour conserves flux only up to 4 bands, and light that
    leaves along a diagonal is seen by no sample with many bands.
    """

    name = "lpv-2009"
    summary = "the first light propagation volumes: one sample and one lobe a neighbour (2009)"
    dimensions = (2, 3)
    options = (PROPAGATION_FACTOR,)

    def _build(self, basis: AngularBasis) -> Stencil:
        offsets = AXIAL[basis.dimension]
        directions = unit(offsets)
        angle = basis.total_angle / len(directions)
        reception = angle * basis.evaluate(directions)[:, None, :]
        emission = basis.lambertian(directions)[:, :, None]
        stencil = Stencil.from_faces(basis, offsets, reception, emission)
        return stencil.scaled(self.values["propagation_factor"])
