"""Light propagation volumes: flux onto the faces of the neighbour, one cosine lobe per face."""

from __future__ import annotations

import numpy as np

from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil
from propagators.base import Option, StencilPropagator
from propagators.directions import AXIAL, Array, unit
from propagators.faces import Faces, faces_of
from propagators.options import PROPAGATION_FACTOR

_NVIDIA_GAIN = {"cascade": 3.8 / 4, "hierarchy": 3.0 / 4}


class LightPropagationVolume(StencilPropagator):
    """LPV face flux (Kaplanyan & Dachsbacher 2010, section 3.3; numerics §3).

    From a source cell's centre, the flux Φ_f onto each face f of an axial neighbour, except the
    one they share, becomes a clamped-cosine lobe of flux Φ_f at the neighbour's centre pointing
    at f: T_d = Σ_f lobe_f ⊗ v_f, over 3 edges in 2D and 5 squares in 3D. With flux="transfer"
    v_f = ∫_f y dω, exactly; with "central" v_f = Δω_f y(ω_c), one sample in the direction ω_c of
    the face's centre (Kirsch 2010, 6.1) or of the middle of its visibility cone, ∫_f ω dω (the
    paper's words).

    What it gets wrong: the cosine lobe forgets where light came from, so light walks at random.
    A Lambertian source's mean displacement stays near 1.6 cells in 2D and 0.93 in 3D however long
    the run, its radius grows like the square root of the iterations, and more bands change
    neither. See fig5-one-light. `transfer` conserves flux for any number of bands, `central` up
    to 4.
    """

    name = "lpv"
    summary = "light propagation volumes: face flux and cosine lobes (Kaplanyan & Dachsbacher 2010)"
    dimensions = (2, 3)
    options = (
        Option(
            "flux",
            str,
            "transfer",
            "flux onto a face: exact, or one sample",
            ("transfer", "central"),
        ),
        Option(
            "sample",
            str,
            "face-centre",
            "where `central` samples a side face",
            ("face-centre", "cone-centre"),
        ),
        Option(
            "normalization",
            str,
            "conserving",
            "conserving (Kirsch 2010), the formulas as published (gain 1/(2 pi) a step in 2D, "
            "1/(4 pi) in 3D), or the gain of NVIDIA's sample",
            ("conserving", "published", "nvidia"),
        ),
        Option(
            "amplifier",
            str,
            "cascade",
            "which NVIDIA sample: cascade (gain 0.95) or hierarchy (0.75)",
            tuple(_NVIDIA_GAIN),
        ),
        Option(
            "clamp",
            bool,
            False,
            "set negative intensity to zero before use, as GPU code does; creates energy",
        ),
        PROPAGATION_FACTOR,
    )

    def _build(self, basis: AngularBasis) -> Stencil:
        offsets = AXIAL[basis.dimension]
        faces = [faces_of(offset) for offset in offsets]
        reception = np.array([self._reception(basis, each) for each in faces])
        emission = np.array([basis.lambertian(each.normals).T for each in faces])
        stencil = Stencil.from_faces(basis, offsets, reception, emission, self.values["clamp"])
        return stencil.scaled(self._gain(basis) * self.values["propagation_factor"])

    def _gain(self, basis: AngularBasis) -> float:
        gains = {
            "conserving": 1.0,
            "published": 1.0 / basis.total_angle,
            "nvidia": _NVIDIA_GAIN[self.values["amplifier"]],
        }
        return gains[self.values["normalization"]]

    def _reception(self, basis: AngularBasis, faces: Faces) -> Array:
        """Flux onto each face per unit of each coefficient, (F, size)."""
        if self.values["flux"] == "transfer":
            return faces.regions.integral(basis)
        angles = faces.regions.angles[:, None]
        if self.values["sample"] == "face-centre":
            return angles * basis.evaluate(unit(faces.centres))
        return angles * faces.regions.middle_values(basis)
