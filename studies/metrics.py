"""Error measures between a field and a reference (numerics §10), one function each.

All take arrays over cells: coefficients (size, *shape) of the same basis, or samples over
direction (K, *shape); colours, if any, come first and are summed over. `mask` (*shape) chooses
cells. A measure is 0 for equal fields; relative ones are 1 for a black field.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field

Array = NDArray[np.float64]
Mask = NDArray[np.bool_] | None


#: A cell is dark if its flux is at most this part of the brightest one's.
DARK = 1e-12


def relative_l2(field: Field, reference: Field, mask: Mask = None) -> float:
    """‖c − c_ref‖ / ‖c_ref‖ over all coefficients and cells."""
    return _relative(*_pair(field, reference, mask))


def best_scale(field: Field, reference: Field, mask: Mask = None) -> float:
    """The factor on the field that brings it closest to the reference in relative_l2.

    Users of real-time renderers tune one such number (the octree thesis' p).
    """
    values, exact = _pair(field, reference, mask)
    length = float(np.sum(values * values))
    return float(np.sum(values * exact)) / length if length > 0 else 1.0


def scaled_l2(field: Field, reference: Field, mask: Mask = None) -> float:
    """relative_l2 after the best single scale factor."""
    values, exact = _pair(field, reference, mask)
    return _relative(values * best_scale(field, reference, mask), exact)


def infinity_mean_absolute(field: Field, reference: Field, mask: Mask = None) -> float:
    """Mean over cells of ‖c − c_ref‖∞ (the octree thesis 6.2)."""
    values, exact = _pair(field, reference, mask)
    return float(np.mean(_largest(values - exact)))


def infinity_mean_relative(field: Field, reference: Field, mask: Mask = None) -> float:
    """Mean over cells of ‖c − c_ref‖∞ / ‖c_ref‖∞ (the octree thesis 6.2).

    Cells whose reference is exactly dark are left out: their ratio has no value.
    """
    values, exact = _pair(field, reference, mask)
    error, size = _largest(values - exact), _largest(exact)
    lit = size > 0
    return float(np.mean(error[lit] / size[lit])) if np.any(lit) else 0.0


def scalar_flux_error(field: Field, reference: Field, mask: Mask = None) -> float:
    """Relative L2 over cells of the scalar flux (band 0)."""
    return _relative(*_pair(field.with_bands(1), reference.with_bands(1), mask))


def net_flux_error(field: Field, reference: Field, mask: Mask = None) -> float:
    """Relative L2 over cells of the net flux (band 1); NaN for fields of one band."""
    if field.basis.bands < 2 or reference.basis.bands < 2:
        return float("nan")
    return band_errors(field.with_bands(2), reference.with_bands(2), mask)[1]


def band_errors(field: Field, reference: Field, mask: Mask = None) -> list[float]:
    """Relative L2 over cells of every band's coefficients alone, (bands,)."""
    values, exact = _pair(field, reference, mask)
    bands = reference.basis.degrees
    return [
        _relative(values[..., bands == band, :], exact[..., bands == band, :])
        for band in range(reference.basis.bands)
    ]


def leak(field: Field, reference: Field, mask: Mask = None) -> float:
    """Flux in cells that are exactly dark in the reference, as a share of the flux in all cells.

    Σ_dark |Φ| / Σ |Φ| of the field's scalar flux. 0 if the reference leaves no cell dark. Counts
    what gets through walls, and what a scheme sends where no light goes even without walls, behind
    an area light for example.
    """
    values, exact = _pair(field.with_bands(1), reference.with_bands(1), mask)
    amount = np.abs(values)
    total = float(amount.sum())
    # The reference is good to about 1e-13 of its largest coefficient.
    dark = np.abs(exact) <= DARK * np.abs(exact).max(initial=0.0)
    return float(amount[dark].sum()) / total if total > 0 else 0.0


def angular_l2(
    field: Field, directions: ArrayLike, intensity: ArrayLike, mask: Mask = None
) -> float:
    """Relative L2 over cells and all directions, against the exact intensity.

    directions: (K, dimension), evenly spread. intensity: ([colours,] K, *shape), not
    band-limited, so that the truncation to n bands counts as the error it is.
    """
    values = field.evaluate(directions)
    exact = np.asarray(intensity, float)
    if values.shape != exact.shape:
        raise bad_input("intensity", exact.shape, f"must be of shape {values.shape}")
    return _relative(_cells(values, field, mask), _cells(exact, field, mask))


def representation_floor(
    reference: Field, directions: ArrayLike, intensity: ArrayLike, mask: Mask = None
) -> float:
    """The angular_l2 that no field with this number of bands can beat.

    It is the error of the exact intensity projected to n bands, √(‖I‖² − ‖c‖²) / ‖I‖. Computed
    on the samples themselves, so that it is never above the error of another field on them.
    """
    basis = reference.basis.evaluate(np.asarray(directions, float))
    exact = _cells(np.asarray(intensity, float), reference, mask)
    coefficients = np.linalg.lstsq(basis, _direction_first(exact), rcond=None)[0]
    return _relative(basis @ coefficients, _direction_first(exact))


@dataclass(frozen=True)
class Measure:
    """An entry of the registry: what a column of a table is called and means.

    function: of a field, its reference and, if wanted, a mask.
    """

    name: str
    meaning: str
    function: Callable[..., float]


#: Measures that need only two fields. A new one is one line here.
MEASURES = {
    measure.name: measure
    for measure in (
        Measure("coefficients", "relative L2 of all coefficients", relative_l2),
        Measure("scaled", "the same after the best single scale factor", scaled_l2),
        Measure("best_scale", "that factor", best_scale),
        Measure("scalar_flux", "relative L2 of band 0", scalar_flux_error),
        Measure("net_flux", "relative L2 of band 1", net_flux_error),
        Measure(
            "infinity_mean", "mean relative infinity norm (thesis 6.2)", infinity_mean_relative
        ),
        Measure("infinity_abs", "mean absolute infinity norm (thesis 6.2)", infinity_mean_absolute),
        Measure("leak", "flux in cells that are exactly dark, as a share of all", leak),
    )
}


def _pair(field: Field, reference: Field, mask: Mask) -> tuple[Array, Array]:
    """Both coefficient arrays as ([colours,] size, cells)."""
    if field.basis != reference.basis:
        raise bad_input("reference", reference.basis, "must have the field's basis", [field.basis])
    if field.values.shape != reference.values.shape:
        raise bad_input("reference", reference.values.shape, f"must be {field.values.shape}")
    return _cells(field.values, field, mask), _cells(reference.values, reference, mask)


def _cells(values: NDArray[np.floating], field: Field, mask: Mask) -> Array:
    """(..., *shape) as (..., cells), the masked ones only."""
    flat = values.reshape(*values.shape[: -field.grid.dimension], -1).astype(float)
    if mask is None:
        return np.asarray(flat)
    if mask.shape != field.grid.shape:
        raise bad_input("mask", mask.shape, f"must be of shape {field.grid.shape}")
    return np.asarray(flat[..., mask.ravel()])


def _direction_first(values: Array) -> Array:
    """([colours,] K, cells) as (K, everything else)."""
    moved = np.moveaxis(values, -2, 0)
    return np.asarray(moved.reshape(moved.shape[0], -1))


def _largest(values: Array) -> Array:
    return np.asarray(np.abs(values).max(axis=-2))


def _relative(values: Array, exact: Array) -> float:
    size = float(np.linalg.norm(exact))
    error = float(np.linalg.norm(values - exact))
    if size == 0:
        return 0.0 if error == 0 else float("inf")
    return error / size
