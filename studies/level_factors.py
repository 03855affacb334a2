r"""Which factor a scheme needs on each level of an octree: fitted, and from theory.

Light of the mean of its children, propagated on level i, must be multiplied by f_i to match the
uniform grid (numerics §7). Two limits bracket it. Light that keeps its way passes 2 of the 2^D
children: f_i = 2^i. Light that diffuses obeys −κ h² ∇²S = q with the same κ in cells² a step on
every level, so that a cell 2^i times as large carries 4^i times less of it: f_i = 4^i. LPV's
cosine lobe makes light a random walk, and is in between as long as borders are near: far from a
source at height y (in cells of its level) above a border, light is that of a dipole of strength

    y + c,  c = m + z,

with m the cells that a lobe gets before it has forgotten its direction, and z how far beyond the
border the light seems to vanish (its extrapolation length). In metres the dipole is h (y + c), so

    f_i = 2^i (y_0 + c) / (y_i + c):

which is 2^i for a scheme whose light runs straight (c = ∞) and 4^i far away from borders, where
y_i ≈ y_0 / 2^i ≫ c.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import eye_array, kron
from scipy.sparse.linalg import spsolve

from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.stencil import Stencil
from propagators import StencilPropagator
from studies.level_errors import downsampled, whole_cells
from studies.metrics import best_scale, relative_l2

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Cells across the slab in which a scheme's memory is measured, and the stretch of straight line
#: in it, from each of its sides.
_SLAB, _FIRST, _LAST = 400, 50, 150
#: A slope this small is none: light does not fall off towards the border.
_FLAT = 1e-9


@dataclass(frozen=True)
class LevelFit:
    """The factor of one level, on band 0.

    fitted: the factor on the mean that brings the level closest to the uniform solution in
    relative L2 of the scalar flux; coefficients: the same for all coefficients. error_mean,
    error_flux, error_fitted: relative L2 of the scalar flux with the factors 1, 2^i and `fitted`.
    """

    level: int
    fitted: float
    coefficients: float
    error_mean: float
    error_flux: float
    error_fitted: float


def fit_level_factors(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int = 2,
    levels: int = 3,
    mask: Mask | None = None,
    tolerance: float = 1e-8,
    **options: Any,
) -> list[LevelFit]:
    """Best factors of levels 1, 2, … for a scene, all levels converged.

    mask: cells of level 0 to compare in; a coarse cell counts if all of its cells do. options:
    further arguments of Simulation.
    """
    arguments: dict[str, Any] = {**options, "levels": levels, "normalization": "mean"}
    simulation = Simulation(scene, propagator, bands, skip=False, **arguments)
    simulation.solve(tolerance)
    chosen = np.ones(scene.grid.shape, bool) if mask is None else mask
    fits = []
    for number in range(1, levels):
        field = simulation.level(number).accumulated
        exact, inside = downsampled(simulation.accumulated, number), whole_cells(chosen, number)
        light, goal = field.with_bands(1), exact.with_bands(1)
        fitted = best_scale(light, goal, inside)
        errors = [
            relative_l2(replace(light, values=factor * light.values), goal, inside)
            for factor in (1.0, 2.0**number, fitted)
        ]
        fits.append(LevelFit(number, fitted, best_scale(field, exact, inside), *errors))
    return fits


def factor_near_border(level: int, finest: float, own: float, memory: float) -> float:
    """f_i = 2^i (y_0 + c) / (y_i + c), see the module.

    finest, own: height of the source above the border in cells of level 0 and of its own level.
    memory: c in cells, see `light_memory`; infinity for light that runs straight.
    """
    if np.isinf(memory):
        return 2.0**level
    return float(2.0**level * (finest + memory) / (own + memory))


def light_memory(stencil: Stencil) -> tuple[float, float]:
    """m and z in cells: what a lobe remembers of its direction, and the extrapolation length.

    From the converged light of a slab that is infinite across: a straight line on both sides of
    a source in its middle, which vanishes z beyond the border, and points to a place m in front
    of a Lambertian source. Infinite for a scheme whose light runs straight: no slope to speak of.
    For schemes that lose no light on the way.
    """
    basis, size = stencil.basis, stencil.basis.size
    operator = eye_array(_SLAB * size, format="csc")
    for step in (-1, 0, 1):
        transfer = stencil.transfer[stencil.offsets[:, 0] == step].sum(axis=0)
        operator = operator - kron(eye_array(_SLAB, k=-step), np.asarray(transfer), format="csc")
    forward = np.eye(basis.dimension)[0]
    sources = np.zeros((_SLAB, size, 2))
    sources[_SLAB // 2] = np.stack([basis.isotropic(), basis.lambertian(forward)], axis=-1)
    light = spsolve(operator.tocsc(), sources.reshape(-1, 2)).reshape(_SLAB, size, 2)[:, 0]
    place = np.arange(_SLAB) + 0.5
    rise, height = np.polyfit(place[_FIRST:_LAST], light[_FIRST:_LAST, 0], 1)
    if abs(rise) * _SLAB < _FLAT * abs(light[:, 0]).max():
        return float("inf"), float("inf")
    border = float(height / rise)
    # Slopes to both sides are as the distances to the other end of the wider slab.
    left = np.polyfit(place[_FIRST:_LAST], light[_FIRST:_LAST, 1], 1)[0]
    right = np.polyfit(place[-_LAST:-_FIRST], light[-_LAST:-_FIRST, 1], 1)[0]
    seen = (_SLAB + 2 * border) * right / (right - left) - border
    return float(seen - place[_SLAB // 2]), border
