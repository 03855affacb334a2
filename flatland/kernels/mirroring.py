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
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis
from flatland.kernels.layout import Layout
from flatland.kernels.reports import Buffer
from flatland.symmetry import component_parities

_POINTER, _INTEGER = ctypes.c_void_p, ctypes.c_int64
#: Of `mirror(S, rule, box, first_row, last_row, sums)`, as a sweep calls it.
_SIGNATURE = ctypes.CFUNCTYPE(None, *[_POINTER] * 3, *[_INTEGER] * 2, _POINTER)


class Mirrors:
    """Makes images on one layout that has mirrors. sums: components that steps report."""

    def __init__(self, layout: Layout, basis: AngularBasis, sums: tuple[int, ...]) -> None:
        self.function: int = compiled_mirror(layout.dtype).address
        self._call: Callable[..., None] = _SIGNATURE(self.function)
        self.rule = _rule(layout, component_parities(basis), sums)

    def fill(
        self, buffer: Buffer, rows: int, box: NDArray[np.int64], sums: NDArray[np.float64]
    ) -> None:
        """Images of all rows of a box; from `sums` goes what `steps` of halves has too much."""
        places = [array.ctypes.data for array in (buffer, self.rule, box)]
        self._call(*places, 0, rows, sums.ctypes.data)


def _rule(layout: Layout, parities: NDArray[np.int64], sums: tuple[int, ...]) -> NDArray[np.int64]:
    """Where everything is: see `_image_rows`, which reads it. A grid in 2D is one plane."""
    missing = 3 - len(layout.shape)
    positions = [sums.index(k) if k in sums else -1 for k in range(layout.components)]
    numbers = [
        *(layout.front, layout.component_stride, layout.components, len(sums)),
        *((1,) * missing + layout.shape),
        *((0,) * missing + layout.strides[:-1]),
        *((0,) * missing + layout.mirrors),
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
        head = carray(rule_at, 12)
        front, stride, components, reported = head[0], head[1], head[2], head[3]
        planes, rows, columns, plane, row = head[4], head[5], head[6], head[7], head[8]
        of_planes, of_rows, of_columns = head[9], head[10], head[11]
        rule = carray(rule_at, 12 + 4 * components)
        signs = rule[12 : 12 + 3 * components].reshape(3, components)
        positions = rule[12 + 3 * components :]
        light = carray(light_at, 2 * front + components * stride)
        sums = carray(sums_at, reported + 1)
        box = carray(box_at, 5)
        width = columns + (1 if of_columns else 0)
        for r in range(first, last):
            p, q = box[0] + r // box[2], box[1] + r % box[2]
            base = front + p * plane + q * row
            next_row = of_rows if of_rows and q == rows - of_rows else 0
            next_plane = of_planes if of_planes and p == planes - of_planes else 0
            # Half a layer too much is counted where it lies on a mirror.
            share = 0.5 if of_planes == 2 and p == planes - 1 else 1.0
            share *= 0.5 if of_rows == 2 and q == rows - 1 else 1.0
            begin = 0 if share != 1.0 else (columns - 1 if of_columns == 2 else columns)
            for k in range(components):
                at = base + k * stride
                if of_columns:
                    light[at + columns] = signs[2, k] * light[at + columns - of_columns]
                if next_row:
                    for i in range(at, at + width):
                        light[i + next_row * row] = signs[1, k] * light[i]
                if next_plane:
                    for i in range(at, at + width):
                        light[i + next_plane * plane] = signs[0, k] * light[i]
                if next_row and next_plane:
                    sign, away = signs[0, k] * signs[1, k], next_row * row + next_plane * plane
                    for i in range(at, at + width):
                        light[i + away] = sign * light[i]
                for c in range(begin, columns):
                    value = float(light[at + c])
                    own = share * (0.5 if of_columns == 2 and c == columns - 1 else 1.0)
                    if positions[k] >= 0:
                        sums[positions[k]] -= (1.0 - own) * value
                    sums[reported] -= (1.0 - own) * value * value

    return mirror
