"""How wrong the levels of an octree are: by the thesis' measures, and against the uniform grid.

A level is compared with finer light that is downsampled to its cells. The octree thesis (6.2) takes
the next finer level of the same octree. Its section 7 says what is wrong with that: coarse light
is ahead of fine light, so that after few steps a level is compared with darkness. Here stands
beside it what it asks for, a uniform solution computed in advance.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.octree import halved
from flatland.scene import Scene
from flatland.simulation import Simulation
from propagators import StencilPropagator
from studies.metrics import MEASURES, relative_l2

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Measures of `against_uniform` that a history keeps.
_KEPT = ("coefficients", "scalar_flux", "infinity_mean", "infinity_abs")


@dataclass(frozen=True)
class ThesisErrors:
    """The octree thesis' e_abs and e_rel of one moment.

    absolute, relative: means over the elements of each level from 1 on, (levels − 1,).
    printed_absolute, printed_relative: the two numbers as printed (6.2), in 3D
    7 / (8^l − 8) · Σ_{i=1}^{l−1} Σ_p, generalised to (2^D − 1) / (2^{Dl} − 2^D). That factor is the
    inverse of the number of elements in O_0 … O_{l−2}, 2^D times those of O_1 … O_{l−1} that are
    summed: the printed mean is 2^D times too small. corrected_absolute, corrected_relative: over
    the elements that are there.
    """

    absolute: Array
    relative: Array
    printed_absolute: float
    printed_relative: float
    corrected_absolute: float
    corrected_relative: float


def downsampled(field: Field, level: int) -> Field:
    """Means over the cells of a level, counted from the field's own grid as level 0."""
    for _ in range(level):
        values = halved(field.values, field.grid.dimension)
        field = Field(field.grid.coarsen(), field.basis, values)
    return field


def whole_cells(mask: Mask, level: int) -> Mask:
    """Cells of a level all of whose cells of level 0 are in the mask; half-covered ones are not."""
    share = mask.astype(float)
    for _ in range(level):
        share = halved(share, mask.ndim)
    return np.asarray(share == 1.0)


def thesis_errors(levels: Sequence[Field]) -> ThesisErrors:
    """e_abs and e_rel of an octree's fields, finest first; see ThesisErrors.

    Per element the norm ‖v‖∞ = max_i |v_i| (printed without the absolute value) over coefficients
    and colours of O_i − Ô_i, Ô_i the mean of the children in O_{i−1}; relative to ‖O_i‖∞, and left
    out of the sum where that is 0. Elements without all their children are left out altogether.
    Raises InputError for fewer than two levels.
    """
    if len(levels) < 2:
        raise bad_input("levels", len(levels), "must be at least 2 to be compared")
    sums, counts = np.zeros((2, len(levels) - 1)), np.zeros(len(levels) - 1)
    whole = np.ones(levels[0].grid.shape, bool)
    for number, (fine, coarse) in enumerate(itertools.pairwise(levels)):
        inside = whole_cells(whole, number + 1)
        difference = coarse.values - halved(fine.values, fine.grid.dimension)
        error, size = _norm(difference, coarse)[inside], _norm(coarse.values, coarse)[inside]
        lit = size > 0
        sums[:, number] = error.sum(), (error[lit] / size[lit]).sum()
        counts[number] = inside.sum()
    children = 2 ** levels[0].grid.dimension
    printed = (children - 1) / (float(children) ** len(levels) - children)
    means = sums / np.maximum(counts, 1)
    total = sums.sum(axis=1)
    corrected = total / counts.sum()
    return ThesisErrors(means[0], means[1], *(printed * total).tolist(), *corrected.tolist())


def against_uniform(
    levels: Sequence[Field], uniform: Field, mask: Mask | None = None
) -> list[dict[str, float]]:
    """Every measure of studies.metrics per level, against the uniform solution downsampled.

    mask: cells of level 0 to compare; a coarse cell counts if all of its cells do.
    """
    chosen = np.ones(uniform.grid.shape, bool) if mask is None else mask
    rows = []
    for number, field in enumerate(levels):
        exact, inside = downsampled(uniform, number), whole_cells(chosen, number)
        rows.append(
            {name: entry.function(field, exact, inside) for name, entry in MEASURES.items()}
        )
    return rows


def error_history(
    scene: Scene,
    propagator: StencilPropagator,
    bands: int,
    levels: int,
    iterations: int,
    uniform: Field | None = None,
    mask: Mask | None = None,
    blend: float | None = None,
    **options: Any,
) -> xr.Dataset:
    """Errors after every iteration, 0 to `iterations`, of every level and of the merged field.

    uniform: what to compare with; the converged field of level 0 if not given. options: further
    arguments of Simulation. Variables (iteration, level): `coefficients`, `scalar_flux`,
    `infinity_mean`, `infinity_abs` against the uniform solution, `thesis_absolute` and
    `thesis_relative` (level 0 has none: NaN). Variables (iteration): `merged`, relative L2 of the
    merged field's coefficients; `printed_absolute` … `corrected_relative` of ThesisErrors.
    """
    if uniform is None:
        own = {name: value for name, value in options.items() if name != "level_factors"}
        alone = Simulation(scene, propagator, bands, **own)
        alone.solve()
        uniform = alone.accumulated
    simulation = Simulation(scene, propagator, bands, levels, skip=False, **options)
    simulation.start()
    rows = []
    for iteration in range(iterations + 1):
        if iteration:
            simulation.step()
        fields = [simulation.level(number).accumulated for number in range(levels)]
        rows.append(_moment(fields, uniform, mask))
        rows[-1]["merged"] = relative_l2(simulation.merge(blend), uniform, mask)
    data = {
        name: (("iteration", "level") if np.ndim(rows[0][name]) else ("iteration",), values)
        for name in rows[0]
        for values in [np.array([row[name] for row in rows])]
    }
    return xr.Dataset(data, {"iteration": np.arange(iterations + 1), "level": np.arange(levels)})


def _moment(fields: Sequence[Field], uniform: Field, mask: Mask | None) -> dict[str, Array | float]:
    """All errors of one iteration, by name."""
    errors = against_uniform(fields, uniform, mask)
    row: dict[str, Array | float] = {
        name: np.array([entry[name] for entry in errors]) for name in _KEPT
    }
    if len(fields) > 1:
        thesis = thesis_errors(fields)
        row["thesis_absolute"] = np.concatenate([[np.nan], thesis.absolute])
        row["thesis_relative"] = np.concatenate([[np.nan], thesis.relative])
        for name in ("printed", "corrected"):
            for kind in ("absolute", "relative"):
                row[f"{name}_{kind}"] = getattr(thesis, f"{name}_{kind}")
    return row


def _norm(values: NDArray[np.floating], field: Field) -> Array:
    """‖v‖∞ over coefficients and colours, (*shape)."""
    return np.asarray(np.abs(values).reshape(-1, *field.grid.shape).max(axis=0), float)
