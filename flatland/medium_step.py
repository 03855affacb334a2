"""A stencil's step through a medium: light collides on its way from cell to cell."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatland.errors import SchemeWarning, bad_input
from flatland.grid import Grid
from flatland.kernels import Reflection
from flatland.ledger import Ledger
from flatland.medium import Medium, collision_probability, share_ahead
from flatland.moments import spread_ratio
from flatland.occlusion import Occlusion
from flatland.stability import symbol
from flatland.stencil import Stencil

Array = NDArray[np.float64]

#: Steps between centres, or the mean chord of a cell, π h/4 (Cauchy), where faces are counted.
LENGTHS = {"centre": 1.0, "chord": np.pi / 4}
#: Relative error of the mean square distance that light spreads over, beyond which users are told.
WORST_SPREAD = 0.05


@dataclass(frozen=True, eq=False)
class MediumStep:
    """S'(x + d) += (1 - p_d) F, F = τ(x, d) T_d S(x); what collides comes back in component 0.

    Of the flux of F the share p_d = 1 - e^(-σ |d| h) collides, a share b_d of it at x + d and the
    rest at x (`share_ahead`); each cell gets c times what collides in it, the same in all
    directions. What is put ahead is part of the transfer matrices, what stays behind is local, as
    what a wall sends back is.

    vacuum: the scheme without the medium. optical: σ_t h. probability, share: p and b (K,).
    stencil: the scheme with all that goes ahead; its flux gain is that of the vacuum. behind: (K,),
    what stays, per flux that the stencil sends along d.
    """

    vacuum: Stencil
    medium: Medium
    optical: float
    probability: Array
    share: Array
    stencil: Stencil
    behind: Array

    def require_walls(self, walls: Occlusion) -> None:
        """Raise InputError for walls that are not read in the first step."""
        if walls.free_first_step:
            rule = "cannot be read in a medium, as the first step would have to pass it"
            raise bad_input("blocking", "fuzzy", rule, ("exact", "none"))

    def occlusion(self, walls: Occlusion, shape: tuple[int, ...]) -> Occlusion:
        """The walls, and what stays in each cell among what comes back."""
        open_share = walls.transmittance
        if open_share is None:
            open_share = np.ones((len(self.behind), *shape))
        cells = np.stack(np.unravel_index(np.arange(int(np.prod(shape))), shape), axis=1)
        lobes = np.zeros((len(cells), len(self.behind), self.stencil.basis.size))
        lobes[:, :, 0] = self.behind * open_share.reshape(len(self.behind), -1).T
        first_row = _first_row(self.probability, self.share, self.medium.albedo)
        found = []
        for part in walls.reflections or (None,):
            both = lobes.copy()
            if part is not None:
                rows = np.ravel_multi_index(tuple(part.cells.T), shape)
                both[rows] += part.lobes / first_row[:, None]
            found.append(Reflection(cells, both))
        return replace(walls, reflections=tuple(found))

    def book(self, ledger: Ledger, sent: Array, walls: Occlusion) -> Ledger:
        """The ledger with what the medium took apart from what walls took.

        sent: (size, *shape), all light that has left its cell [W/rad], summed. walls: those that
        `occlusion` was given. Both shares are linear in the light that is sent.
        """
        passed = self._passed(sent, walls).reshape(len(self.share), -1).sum(axis=1)
        collided = self.probability * passed
        absorbed = (1 - self.medium.albedo) * collided.sum()
        if walls.transmittance is None:
            absorbed = ledger.absorbed  # there are no walls
        stayed = self.medium.albedo * (collided * (1 - self.share)).sum()
        return replace(
            ledger,
            absorbed=ledger.absorbed - absorbed,
            reflected=ledger.reflected - stayed,
            medium=ledger.medium + absorbed,
        )

    def collided(self, sent: Array, walls: Occlusion) -> Array:
        """Flux (*shape) that collides in each cell [W], of the light that was sent in all.

        Over σ_t it is the integral of radiance over the cell and all directions.
        """
        fluxes = self._passed(sent, walls)
        result = np.zeros(fluxes.shape[1:])
        for d, offset in enumerate(self.vacuum.offsets.tolist()):
            collided = self.probability[d] * fluxes[d]
            result += (1 - self.share[d]) * collided
            steps = list(zip(map(int, offset), map(int, result.shape)))
            come = tuple(slice(max(0, -o), n - max(0, o)) for o, n in steps)
            go = tuple(slice(max(0, o), n - max(0, -o)) for o, n in steps)
            result[go] += self.share[d] * collided[come]
        return result

    def _passed(self, sent: Array, walls: Occlusion) -> Array:
        """Flux (K, *shape) that starts along each offset and meets no wall [W]."""
        fluxes = (
            np.tensordot(self.vacuum.transfer[:, 0, :], sent, 1) * self.vacuum.basis.flux_weight
        )
        return fluxes if walls.transmittance is None else fluxes * walls.transmittance

    def symbol(self, waves: NDArray[np.inexact]) -> NDArray[np.complex128]:
        """What a step does to a wave (..., dimension), complex or not, (..., size, size).

        With what it leaves behind, without walls.
        """
        rows = np.einsum("d,dk->k", self.behind, self.stencil.transfer[:, 0, :])
        result = symbol(self.stencil.offsets, self.stencil.transfer, waves)
        result[..., 0, :] += rows
        return result


def in_medium(
    stencil: Stencil,
    medium: Medium,
    grid: Grid,
    share: str = "moment",
    step_length: str = "centre",
) -> MediumStep:
    """The step of a stencil through a medium.

    share: see `share_ahead`. step_length: "centre" or "chord", see LENGTHS: face counting schemes
    get the absorption in a uniform isotropic field right with the chord, all others with centres.
    Raises InputError for a clamped scheme, whose books no linear share could part, and for cells
    that nothing passes.
    """
    if stencil.clamp:
        rule = "knows no medium: what it cuts off is neither absorbed nor scattered"
        raise bad_input("clamp", True, rule, (False,))
    if step_length not in LENGTHS:
        raise bad_input("step_length", step_length, "is unknown", LENGTHS)
    x = LENGTHS[step_length] * medium.optical_lengths(stencil.offsets, grid.spacing)
    medium.require_passable(float(x.max()))
    p, b = collision_probability(x), share_ahead(x, share)
    first_row = _first_row(p, b, medium.albedo)
    factors = np.repeat((1 - p)[:, None], stencil.basis.size, axis=1)
    factors[:, 0] = first_row
    slowed = replace(
        stencil,
        transfer=stencil.transfer * factors[:, :, None],
        emission=None if stencil.emission is None else stencil.emission * factors[:, :, None],
        gain=stencil.flux_gain,
    )
    behind = medium.albedo * p * (1 - b) / first_row
    optical = medium.extinction * grid.spacing
    return MediumStep(stencil, medium, optical, p, b, slowed, behind)


def _first_row(probability: Array, share: Array, albedo: float) -> Array:
    """Of the flux that a step sends, what goes ahead: row 0 of the stencil over the vacuum's."""
    return np.asarray(1 - probability + albedo * probability * share)


def warn_of_spread(steps: Sequence[MediumStep | None], stacklevel: int = 2) -> None:
    """One SchemeWarning if light diffuses by the wrong distance on any level, with the numbers."""
    found, bands = [], 0
    for level, step in enumerate(steps):
        ratio = 1.0 if step is None else spread_ratio(step)
        if step is not None and abs(ratio - 1) > WORST_SPREAD:
            place = f" (level {level})" if len(steps) > 1 else ""
            found.append(f"{ratio:.1%} of it at {step.optical:.3g} collisions a cell{place}")
            bands = step.vacuum.basis.bands
    if found:
        message = (
            f"in this medium, this scheme with {bands} bands spreads light over the wrong mean "
            f"square distance: over {', '.join(found)}"
        )
        warnings.warn(message, SchemeWarning, stacklevel=stacklevel + 1)
