"""Lattice-Boltzmann lighting, as a propagator."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.blocking import exact_reflection, exact_transmittance
from flatland.errors import SchemeWarning
from flatland.field import Field
from flatland.harmonics import CircularHarmonics
from flatland.injection import inject
from flatland.ledger import Ledger
from flatland.medium import Medium
from flatland.medium_step import WORST_SPREAD
from flatland.memory import require_memory
from flatland.moments import THIN, exact_moments
from flatland.occlusion import without_first_bounces
from flatland.scene import Scene
from propagators.base import Answer, DirectPropagator, Option
from propagators.lattice_boltzmann.lattice import Lattice
from propagators.lattice_boltzmann.rules import (
    PROBABILITIES,
    VELOCITIES,
    WEIGHTS,
    arc_values,
    collision_matrix,
    lattice_moments,
    step_probability,
)
from propagators.options import BOUNCES

Array = NDArray[np.float64]

_VACUUM = Medium(0.0, 0.0)
#: Bands in which lights are put into arcs: populations know no bands, and few would blur a lobe.
INJECTED_BANDS = 16


class LatticeBoltzmann(DirectPropagator):
    """Lattice-Boltzmann lighting (Geist, Rasche, Westall and Schalkoff 2004), in 2D; numerics §13.

    Each cell holds photons at rest and eight populations that go to its neighbours, one cell a
    step; in between, collisions turn shares of them into one another (`collision_matrix`). A
    diffusion in the limit, with D = (3/5)(1/s - 1/2) cells² a step. The probability of a step is
    calibrated so that light of any σ_t h up to 1.29 spreads over the exact mean square distance.
    absorbed="reemit" is as published: what a cell absorbs goes out again a step later, so that in
    the end nothing is absorbed; "lost" takes it away.

    Lights put into populations what they send into their arcs. Walls stop the blocked share of a
    link and send albedo times it back, in populations with n·c > 0 by w n·c. 2D weights, arcs,
    calibration, "lost" and walls are this project's.

    What it gets wrong: it is a method for media. In a vacuum it is discrete ordinates along eight
    streets with unequal bins, 60 to 96 % off (`fig5-one-light`). In a medium the fourth moment is
    up to 8 % low at albedo 0.9, and half of it is missing at albedo 0 and σ_t h = 1.
    """

    name = "lattice-boltzmann"
    summary = "photon populations that stream and collide: for media"
    dimensions: ClassVar = (2,)
    media: ClassVar = True
    options = (
        Option("absorbed", str, "lost", "what becomes of absorbed light", ("lost", "reemit")),
        Option(
            "probability",
            str,
            "calibrated",
            "of a collision in a step: by mean square distance, σ_t h, or 1 - e^(-σ_t h)",
            PROBABILITIES,
        ),
        BOUNCES,
    )

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field, its books, and in the details the `probability` of a collision in a step."""
        self.require_scene(scene)
        basis = CircularHarmonics(bands)
        colours = max(1, scene.colours)
        require_memory(8 * 9 * 10 * colours * scene.grid.cell_count, "grid.shape", scene.grid.shape)
        medium = scene.medium or _VACUUM
        optical = medium.extinction * scene.grid.spacing
        probability = step_probability(optical, self.values["probability"])
        if optical > 0:
            _warn_of_spread(optical, self.values["probability"])
        lattices = self._lattices(scene, medium, probability)
        arcs, fine = arc_values(basis), CircularHarmonics(max(bands, INJECTED_BANDS))
        light = inject(without_first_bounces(scene), fine).values
        light = light.reshape(colours, fine.size, *scene.grid.shape).astype(float)
        values, books = [], []
        for colour, coefficients in enumerate(light):
            lattice = lattices[colour % len(lattices)]
            start = np.zeros((9, *scene.grid.shape))
            start[1:] = np.tensordot(arc_values(fine), coefficients, 1)
            sent = lattice.settled(start)
            density = sent[1:] / (2 * np.pi * WEIGHTS[1:, None, None])
            values.append(np.tensordot(arcs.T, density, 1))
            books.append(_books(lattice, start, sent))
        coloured = scene.colours > 0
        field = Field(scene.grid, basis, np.array(values) if coloured else values[0])
        mixing = np.eye(colours) if coloured else np.ones(1)
        return Answer(field, Ledger.mixed(books, mixing), {"probability": probability})

    def _lattices(self, scene: Scene, medium: Medium, probability: float) -> list[Lattice]:
        """One for all colours, or one for each where walls are coloured."""
        scattered = medium.albedo * probability
        reemits = self.values["absorbed"] == "reemit"
        matrix = collision_matrix(scattered, probability - scattered, reemits)
        segments, links = scene.segments(), VELOCITIES[1:]
        nothing = np.empty((0, 2), np.int64), np.empty((0, 8, 9))
        tau = exact_transmittance(scene.grid, segments, links) if segments else None
        if tau is None:
            return [Lattice(matrix, None, *nothing)]
        open_share = np.concatenate([np.ones((1, *scene.grid.shape)), tau])  # rest stays
        if not (self.values["bounces"] and any(np.any(wall.albedo) for wall in segments)):
            return [Lattice(matrix, open_share, *nothing)]
        lobes: Any = _Populations()
        found = exact_reflection(scene.grid, segments, links, lobes, tau)
        return [Lattice(matrix, open_share, part.cells, part.lobes) for part in found]


@dataclass(frozen=True)
class _Populations:
    """What `exact_reflection` asks of a basis, for populations: their number, and a wall's lobe."""

    size: int = 9
    flux_weight: float = 1.0

    def lambertian(self, normals: Array, flux: float = 1.0) -> Array:
        """Shares (..., 9) w_j max(0, n·c_j) of the flux that a wall sends."""
        shares = WEIGHTS * np.maximum(0.0, normals @ VELOCITIES.T)
        return np.asarray(flux * shares / shares.sum(axis=-1, keepdims=True))


def _books(lattice: Lattice, start: Array, sent: Array) -> Ledger:
    """Of all light that left cells (9, nx, ny); what is not settled yet is inside."""
    passing = sent if lattice.open_share is None else lattice.open_share * sent
    arrived = lattice.arrived(sent)
    left = passing.sum() - arrived.sum()
    back = np.zeros(())
    if len(lattice.cells):
        back = np.einsum("mdj,dm->", lattice.lobes, sent[1:][(slice(None), *lattice.cells.T)])
    kept = (sent - passing).sum() - back
    # Columns of the matrix that do not sum to 1 are what the medium takes.
    taken = ((1 - lattice.matrix.sum(axis=0)) * arrived.sum(axis=(1, 2))).sum()
    inside = (start + lattice.step(sent) - sent).sum()
    return Ledger(start.sum(), left, kept, inside, np.zeros(()), back, taken)


def _warn_of_spread(optical: float, rule: str) -> None:
    """One SchemeWarning if light spreads over the wrong distance; the same for every albedo."""
    # The ratio does not change any more in thinner media.
    thick = max(optical, THIN)
    ratio = lattice_moments(thick, 0.5, rule).r2 / exact_moments(thick, 0.5).r2
    if abs(ratio - 1) > WORST_SPREAD:
        message = (
            f"in this medium, of {optical:.3g} collisions a cell, probability={rule!r} spreads "
            f"light over {ratio:.1%} of the mean square distance"
        )
        warnings.warn(message, SchemeWarning, stacklevel=4)
