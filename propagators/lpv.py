"""Light propagation volumes: flux onto the faces of the neighbour, one cosine lobe per face."""

from __future__ import annotations

import numpy as np

from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil
from propagators.base import Option, StencilPropagator
from propagators.directions import AXIAL_2D, Array, angle, circular, unit
from propagators.options import PROPAGATION_FACTOR

_NVIDIA_GAIN = {"cascade": 3.8 / 4, "hierarchy": 3.0 / 4}


class LightPropagationVolume(StencilPropagator):
    """LPV face flux (Kaplanyan & Dachsbacher 2010, section 3.3; numerics §3).

    From a source cell's centre, the flux Φ_f onto each face f of an axial neighbour, except the
    one they share, becomes a clamped-cosine lobe of flux Φ_f at the neighbour's centre pointing
    at f: T_d = Σ_f lobe_f ⊗ v_f. With flux="transfer" v_f = ∫_f y dω, exactly; with "central"
    v_f = Δω_f y(ω_c), one sample in the direction ω_c of the face's centre or of the middle of
    its visibility cone (Kirsch 2010, 6.1, against the paper's words).

    What it gets wrong: the cosine lobe forgets where light came from, so light walks at random.
    A Lambertian source's mean displacement stays near 1.6 cells however long the run, its radius
    grows like the square root of the iterations, and more bands change neither. See fig5-one-light.
    `transfer` conserves flux for any number of bands, `central` up to 4.
    """

    name = "lpv"
    summary = "light propagation volumes: face flux and cosine lobes (Kaplanyan & Dachsbacher 2010)"
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
            "conserving (Kirsch 2010), the formulas as published (gain 1/(2 pi) a step in 2D), or "
            "the gain of NVIDIA's sample",
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
        reception, emission = zip(*(self._faces(basis, offset) for offset in AXIAL_2D))
        stencil = Stencil.from_faces(
            basis, AXIAL_2D, np.array(reception), np.array(emission), self.values["clamp"]
        )
        return stencil.scaled(self._gain(basis) * self.values["propagation_factor"])

    def _gain(self, basis: AngularBasis) -> float:
        gains = {
            "conserving": 1.0,
            "published": 1.0 / basis.total_angle,
            "nvidia": _NVIDIA_GAIN[self.values["amplifier"]],
        }
        return gains[self.values["normalization"]]

    def _faces(self, basis: AngularBasis, offset: Array) -> tuple[Array, Array]:
        """Reception (3, size) and emission (size, 3) of a neighbour's front and side faces."""
        along = np.asarray(offset, float)
        across = np.array([-along[1], along[0]])
        normals = np.stack([along, across, -across])
        centres = along + 0.5 * normals
        return self._reception(basis, centres, normals), basis.lambertian(normals).T

    def _reception(self, basis: AngularBasis, centres: Array, normals: Array) -> Array:
        circle = circular(basis)
        tangent = 0.5 * np.stack([-normals[:, 1], normals[:, 0]], axis=-1)
        start, stop = angle(centres - tangent), angle(centres + tangent)
        width = (stop - start + np.pi) % (2 * np.pi) - np.pi
        start, width = np.where(width < 0, start + width, start), np.abs(width)
        if self.values["flux"] == "transfer":
            return circle.arc_integral(start, start + width)
        if self.values["sample"] == "face-centre":
            return width[:, None] * circle.evaluate(unit(centres))
        return width[:, None] * circle.evaluate_angles(start + width / 2)
