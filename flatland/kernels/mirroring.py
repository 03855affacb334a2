"""Mirror images behind the last cells of half a grid, where a field is its own image.

A sweep gathers what comes from neighbours; behind a mirror it finds the image of a cell, every
component with the sign that it has there. Each thread copies images of its own rows when it has
swept them, so that nothing waits more often than without.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis
from flatland.kernels.box import sweep_box, whole
from flatland.kernels.layout import Layout
from flatland.kernels.reports import Buffer, StepSums
from flatland.kernels.threads import address

_POINTER, _INTEGER = ctypes.c_void_p, ctypes.c_int64
#: Numbers of a rule before those of components.
_HEAD = 13
#: Of `mirror(S, rule, box, first_row, last_row, sums)`, as a sweep calls it.
_SIGNATURE = ctypes.CFUNCTYPE(None, *[_POINTER] * 3, *[_INTEGER] * 2, _POINTER)


class Mirrors:
    """Makes images on one layout that has mirrors. sums: components that steps report."""

    def __init__(self, layout: Layout, basis: AngularBasis, sums: tuple[int, ...]) -> None:
        rows, self._box = sweep_box(layout, whole(layout.shape))
        self._rule = _rule(layout, basis.parities, sums)
        self._sums = np.zeros(len(sums) + 1)
        #: Addresses of the function and of its second argument.
        self.addresses = (compiled_mirror(layout.dtype).address, address(self._rule))
        self._call: Callable[..., None] = _SIGNATURE(self.addresses[0])
        mirrored = np.array(layout.mirrors) > 0
        self._copies = int(2 ** np.count_nonzero(mirrored))
        parities = basis.parities[list(sums)][:, mirrored]
        #: Of components that are odd under a mirror, both halves cancel.
        self._factors = np.where((parities > 0).all(axis=1), self._copies, 0)
        self._everywhere = (self.addresses[1], address(self._box), 0, rows)

    def fill(self, buffer: Buffer, sums: NDArray[np.float64] | None = None) -> None:
        """All images of a buffer; from `sums` of half a field goes what is counted twice."""
        self._call(
            address(buffer), *self._everywhere, address(self._sums if sums is None else sums)
        )

    def of_whole(self, report: StepSums) -> StepSums:
        """Sums over the whole field, from those over its half, quarter or eighth."""
        copies = self._copies
        return StepSums(
            report.components * self._factors,
            report.squares * copies,
            report.left * copies,
            None if report.sent is None else report.sent * copies,
            None if report.reflected is None else report.reflected * copies,
        )


def _rule(layout: Layout, parities: NDArray[np.int64], sums: tuple[int, ...]) -> NDArray[np.int64]:
    """Where everything is, as the compiled functions read it. A grid in 2D is one plane.

    Where the light begins, components and their distance, numbers reported; planes, rows, columns;
    distances of planes and rows; mirrors; numbers in all; signs per axis and component; places in
    the report.
    """
    missing = 3 - len(layout.shape)
    positions = [sums.index(k) if k in sums else -1 for k in range(layout.components)]
    numbers = [
        *(layout.front, layout.component_stride, layout.components, len(sums)),
        *((1,) * missing + layout.shape),
        *((0,) * missing + layout.strides[:-1]),
        *((0,) * missing + layout.mirrors),
        layout.size,
        *np.vstack([np.ones((missing, layout.components), np.int64), parities.T]).ravel(),
        *positions,
    ]
    return np.array(numbers, np.int64)


@cache
def compiled_mirror(dtype: np.dtype) -> Any:
    """The machine code for numbers of one precision, as a function of C."""
    from numba import carray, cfunc, types

    number = types.float32 if dtype == np.float32 else types.float64
    integers = types.CPointer(types.int64)
    signature = types.void(
        types.CPointer(number), integers, integers, types.int64, types.int64,
        types.CPointer(types.float64),
    )  # fmt: skip

    @cfunc(signature, cache=True, error_model="numpy")
    def mirror(light_at, rule_at, box_at, first, last, sums_at):  # type: ignore[no-untyped-def]
        head = carray(rule_at, _HEAD)
        rule = carray(rule_at, _HEAD + 4 * head[2])
        light = carray(light_at, head[_HEAD - 1])
        sums = carray(sums_at, head[3] + 1)
        box = carray(box_at, 5)
        first_plane, first_row, inner = box[0], box[1], box[2]
        row = first
        while row < last:  # the rows of one plane
            p = row // inner
            begin = row - p * inner
            end = min(inner, begin + last - row)
            _images_in_plane(light, rule, first_plane + p, first_row + begin, first_row + end)
            _count_once(light, rule, first_plane + p, first_row + begin, first_row + end, sums)
            row += end - begin

    return mirror


@njit(error_model="numpy")
def _images_in_plane(light, rule, p, begin, end):  # type: ignore[no-untyped-def]
    """Images of rows of one plane: behind their ends, behind the last row, behind the plane."""
    front, stride, components = rule[0], rule[1], rule[2]
    planes, rows, columns, plane, row = rule[4], rule[5], rule[6], rule[7], rule[8]
    of_planes, of_rows, of_columns = rule[9], rule[10], rule[11]
    signs = rule[_HEAD : _HEAD + 3 * components].reshape(3, components)
    width = columns + (1 if of_columns else 0)
    has_row = of_rows > 0 and begin <= rows - of_rows < end
    for k in range(components):
        base = front + k * stride + p * plane
        if of_columns:
            at = base + begin * row + columns
            for _ in range(begin, end):
                light[at] = light[at - of_columns] if signs[2, k] > 0 else -light[at - of_columns]
                at += row
        if has_row:
            at = base + (rows - of_rows) * row
            _copy(light, at, of_rows * row, width, signs[1, k])
        if of_planes and p == planes - of_planes:
            away, sign = of_planes * plane, signs[0, k]
            for q in range(begin, end):
                _copy(light, base + q * row, away, width, sign)
            if has_row:
                _copy(light, base + rows * row, away, width, sign)


@njit(error_model="numpy")
def _copy(light, start, away, count, sign):  # type: ignore[no-untyped-def]
    for i in range(start, start + count):
        light[i + away] = light[i] if sign > 0 else -light[i]


@njit(error_model="numpy")
def _count_once(light, rule, p, begin, end, sums):  # type: ignore[no-untyped-def]
    """Take from sums over rows of one plane half of what lies on mirrors: it has no image."""
    front, stride, components, reported = rule[0], rule[1], rule[2], rule[3]
    planes, rows, columns, plane, row = rule[4], rule[5], rule[6], rule[7], rule[8]
    of_planes, of_rows, of_columns = rule[9], rule[10], rule[11]
    if of_planes != 2 and of_rows != 2 and of_columns != 2:
        return
    positions = rule[_HEAD + 3 * components :]
    for q in range(begin, end):
        share = 0.5 if of_planes == 2 and p == planes - 1 else 1.0
        share *= 0.5 if of_rows == 2 and q == rows - 1 else 1.0
        start = 0 if share < 1 else columns - (1 if of_columns == 2 else 0)
        for k in range(components):
            at = front + k * stride + p * plane + q * row
            for c in range(start, columns):
                value = float(light[at + c])
                own = share * (0.5 if of_columns == 2 and c == columns - 1 else 1.0)
                if positions[k] >= 0:
                    sums[positions[k]] -= (1.0 - own) * value
                sums[reported] -= (1.0 - own) * value * value
