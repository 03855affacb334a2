"""Light that walls send to one another: radiosity with exact form factors.

Each element i of a wall's side, of length l and albedo ρ, sends the flux B per length with

    B_i = ρ_i / l_i (P_i + Σ_j X_ij B_j / 2)

(Goral, Torrance, Greenberg and Battaile 1984, here in 2D), where P_i is what arrives from the
lights and X_ij = 2 l_i F_ij comes from crossed strings (`exchange`). It leaves as radiance B/2 in
all directions. With B constant on an element this is Galerkin's method: no flux is lost at any
element size, radiosity is right to first order in it, and what arrives farther than an element
from the wall to second order (measured: 1.8 to 2.0 for fields of whole grids).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, cg

from flatland.errors import ConvergenceError
from flatland.memory import require_memory
from propagators.analytic.elements import Elements, cut_walls
from propagators.analytic.exchange import exchange_matrix
from propagators.analytic.geometry import Geometry
from propagators.analytic.lighting import collect_all
from propagators.analytic.panels import collect_panel_light
from propagators.watching import Progress, nobody

Array = NDArray[np.float64]

#: Relative residual asked of the solver, and the one beyond which its answer is refused.
RESIDUAL, WORST_RESIDUAL = 1e-14, 1e-11
#: Share of the largest exchange or flux below which rounding is all there is.
DARK = 1e-13


@dataclass(frozen=True, eq=False)
class Bounced:
    """What walls send back. elements: those that light can reach. radiosity: (K, C) [W / cell]."""

    elements: Elements
    radiosity: Array

    def arriving(self, groups: Array, walls: Array, bands: int, report: Progress = nobody) -> Array:
        """Moments (G, C, 2 bands - 1) of this light on groups of targets (G, P, 4)."""
        parts = self.elements
        lights = parts.panels, parts.first, parts.segments, self.radiosity / 2
        return collect_panel_light(groups, *lights, walls, bands, report)


def bounce(geometry: Geometry, size: float) -> Bounced:
    """All bounces among the walls of a scene, with elements of at most `size` cells."""
    reflecting = np.any(geometry.albedo[geometry.surfaces] > 0, axis=1)
    elements = cut_walls(geometry, size, reflecting)
    elements, visible = _lit(geometry, elements)
    count = len(elements.segments)
    require_memory(count * count * 8, "element", size)
    exchange = exchange_matrix(
        elements.panels, elements.first, elements.segments, geometry.walls, visible
    )
    direct = _direct_flux(geometry, elements.segments)
    albedo = geometry.albedo[elements.owners]
    return Bounced(elements, solve_radiosity(exchange, elements.lengths, albedo, direct))


def all_emitters(geometry: Geometry, bounced: Bounced | None) -> tuple[Array, Array]:
    """Segments (E, 4) that send light to their left, and their radiance (E, C)."""
    if bounced is None:
        return geometry.emitters, geometry.radiance
    emitters = np.concatenate([geometry.emitters, bounced.elements.segments])
    return emitters, np.concatenate([geometry.radiance, bounced.radiosity / 2])


def solve_radiosity(exchange: Array, lengths: Array, albedo: Array, direct: Array) -> Array:
    """Radiosity B (K, C) from X (K, K), lengths (K,), albedo (K, C) and direct flux P (K, C).

    By conjugate gradients on the symmetric form (1 - s X s / 2) y = s P with s = √(ρ/l), B = s y.
    Raises ConvergenceError where light never ends: a closed room of albedo 1.
    """
    result = np.empty(direct.shape)
    for colour in range(direct.shape[1]):
        scale = np.sqrt(albedo[:, colour] / lengths)
        result[:, colour] = scale * _solve_symmetric(exchange, scale, scale * direct[:, colour])
    return result


def _solve_symmetric(exchange: Array, scale: Array, source: Array) -> Array:
    def apply(vector: Array) -> Array:
        return np.asarray(vector - 0.5 * scale * (exchange @ (scale * vector)))

    norm = float(np.linalg.norm(source))
    if norm == 0.0:
        return np.zeros(source.size)
    operator = LinearOperator((source.size, source.size), apply, dtype=float)
    found, _ = cg(operator, source / norm, rtol=RESIDUAL, maxiter=1000)
    residual = float(np.linalg.norm(source / norm - apply(found)))
    if not residual <= WORST_RESIDUAL:
        raise ConvergenceError(
            f"light between walls did not settle (residual {residual:.1e}): "
            "in a closed room its albedo must be below 1"
        )
    return np.asarray(found * norm)


def _lit(geometry: Geometry, elements: Elements) -> tuple[Elements, NDArray[np.bool_]]:
    """The panels that light reaches, over any bounces, and which of them see one another."""
    panels, walls = elements.panels, geometry.walls
    exchange = exchange_matrix(panels, np.arange(len(panels) + 1), panels, walls)
    visible = exchange > DARK * exchange.max(initial=0.0)
    direct = np.abs(_direct_flux(geometry, panels)).max(axis=1)
    _, part = connected_components(visible, directed=False)
    reached = np.isin(part, part[direct > DARK * direct.max(initial=0.0)])
    return elements.only(reached), visible[np.ix_(reached, reached)]


def _direct_flux(geometry: Geometry, targets: Array) -> Array:
    """Flux (K, C) of the lights alone on the left of targets (K, 4)."""
    return collect_all(geometry, np.ascontiguousarray(targets[:, None]), 1)[:, :, 0]
