"""How fast an error falls with the size of the cells: fitted orders with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from flatland.errors import bad_input

Array = NDArray[np.float64]

#: Share of repeated experiments whose interval would hold the true order.
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Order:
    """error = C hᵖ with C of each scene's own. order: p. low, high: its confidence interval.

    points: errors that were fitted. worst: largest |log(error) - fit|, how far from a power law.
    """

    order: float
    low: float
    high: float
    points: int
    worst: float


def fitted_order(sizes: ArrayLike, errors: ArrayLike, groups: ArrayLike) -> Order:
    """The common slope of log(error) over log(size), each group with its own intercept.

    sizes: cell sizes h (K,), any unit per group. errors: (K,), positive. groups: (K,), which scene
    an error belongs to. Least squares on data centred per group; the interval is Student's with
    K - G - 1 degrees of freedom for G groups. It holds the scatter about one power law; that there
    is a power law is an assumption, see `worst`.
    Raises InputError for too few or non-positive numbers.
    """
    across, up = np.log(_positive("sizes", sizes)), np.log(_positive("errors", errors))
    labels = np.unique(np.asarray(groups), return_inverse=True)[1]
    count = int(labels.max(initial=-1)) + 1
    free = across.size - count - 1
    if free < 1:
        rule = f"are too few for {count} groups: {count + 2} needed"
        raise bad_input("errors", across.size, rule)
    x, y = _centred(across, labels, count), _centred(up, labels, count)
    slope = float(x @ y / (x @ x))
    rest = y - slope * x
    half = float(stats.t.ppf((1 + CONFIDENCE) / 2, free) * np.sqrt(rest @ rest / free / (x @ x)))
    return Order(slope, slope - half, slope + half, across.size, float(np.abs(rest).max()))


def fitted_orders(rows: xr.Dataset, measure: str) -> dict[tuple[str, int], Order]:
    """Orders of a study's rows by (scheme, bands), over its scenes; those with enough rows."""
    found = {}
    for scheme, bands in dict.fromkeys(zip(rows["scheme"].values, rows["bands"].values.tolist())):
        own = (rows["scheme"].values == scheme) & (rows["bands"].values == bands)
        own &= np.isfinite(rows[measure].values) & (rows[measure].values > 0)
        chosen = rows.isel(row=own)
        scenes = chosen["scene"].values
        if own.sum() >= len(set(scenes.tolist())) + 2:
            order = fitted_order(chosen["spacing"].values, chosen[measure].values, scenes)
            found[str(scheme), int(bands)] = order
    return found


def _centred(values: Array, labels: NDArray[np.int64], count: int) -> Array:
    means = np.bincount(labels, values, count) / np.bincount(labels, minlength=count)
    return np.asarray(values - means[labels])


def _positive(name: str, values: ArrayLike) -> Array:
    array = np.asarray(values, float)
    if not (array.ndim == 1 and np.all(array > 0) and np.all(np.isfinite(array))):
        raise bad_input(name, values, "must be positive and finite")
    return array
