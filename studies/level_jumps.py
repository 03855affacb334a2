"""How much light jumps where an octree's levels meet (the octree thesis 6.1, figure 14)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field

Array = NDArray[np.float64]
Index = NDArray[np.integer]


@dataclass(frozen=True)
class LevelJumps:
    """Steps of the scalar flux Φ between neighbouring cells, |Φ_x − Φ_y| / ½(|Φ_x| + |Φ_y|).

    borders: pairs of neighbours that are read from different levels. mean, largest: of their
    steps, 0 … 2. within: the mean over all other pairs, what light does without a border.
    excess: mean at borders of the step beyond that of the reference between the same cells; NaN
    without a reference. regained: share of borders at which the coarser side is the brighter one:
    the thesis' "light that has almost died out regains intensity", where light comes from the
    finer side. Without borders mean, largest, excess and regained are 0.
    """

    borders: int
    mean: float
    largest: float
    within: float
    excess: float
    regained: float


def level_jumps(field: Field, index: Index, reference: Field | None = None) -> LevelJumps:
    """Jumps of a merged field, colours added up; see LevelJumps.

    index: the level that each cell was read from, (*shape). Steps are relative to both sides, so
    that faint light counts as much as bright light; pairs of dark cells count as no step.
    """
    flux = _grey_flux(field)
    exact = None if reference is None else _grey_flux(reference)
    at, rest, excess, brighter = [], [], [], []
    for lower, upper in _neighbours(flux.ndim):
        step = _step(flux[lower], flux[upper])
        border = index[lower] != index[upper]
        at.append(step[border])
        rest.append(step[~border])
        finer_first = index[lower] < index[upper]
        gain = np.where(finer_first, flux[upper] - flux[lower], flux[lower] - flux[upper])
        brighter.append(gain[border] > 0)
        if exact is not None:
            excess.append((step - _step(exact[lower], exact[upper]))[border])
    steps = np.concatenate(at)
    return LevelJumps(
        borders=steps.size,
        mean=_mean(steps),
        largest=float(steps.max(initial=0.0)),
        within=_mean(np.concatenate(rest)),
        excess=_mean(np.concatenate(excess)) if excess else float("nan"),
        regained=_mean(np.concatenate(brighter).astype(float)),
    )


def _neighbours(dimension: int) -> Iterator[tuple[tuple[slice, ...], tuple[slice, ...]]]:
    """Lower and upper cell of all pairs along each axis."""
    for axis in range(dimension):
        whole = [slice(None)] * dimension
        lower, upper = list(whole), list(whole)
        lower[axis], upper[axis] = slice(None, -1), slice(1, None)
        yield tuple(lower), tuple(upper)


def _grey_flux(field: Field) -> Array:
    flux = field.scalar_flux()
    return flux.sum(axis=0) if field.coloured else flux


def _step(first: Array, second: Array) -> Array:
    size = 0.5 * (np.abs(first) + np.abs(second))
    return np.asarray(np.abs(first - second) / np.where(size > 0, size, 1.0))


def _mean(values: Array) -> float:
    return float(values.mean()) if values.size else 0.0
