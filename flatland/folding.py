"""Half of what is its own mirror image, and the whole again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis
from flatland.kernels import Layout, Reflection
from flatland.kernels.box import Box, is_empty
from flatland.occlusion import Occlusion
from flatland.stencil import Stencil
from flatland.symmetry import drawn_rounding, image_offsets

Values = NDArray[np.floating]


@dataclass(frozen=True)
class Fold:
    """The lower half along some axes of a grid; the upper one is its mirror image.

    With an even number of cells the mirror lies between two, with an odd one in the middle of one,
    which belongs to the half. axes: none for the whole grid.
    """

    shape: tuple[int, ...]
    basis: AngularBasis
    axes: tuple[int, ...]

    @cached_property
    def half_shape(self) -> tuple[int, ...]:
        """Cells per axis of what is kept."""
        return tuple(-(-n // 2) if a in self.axes else n for a, n in enumerate(self.shape))

    def layout(self, whole: Layout) -> Layout:
        """Where half of the fields lies, with images behind it; the same if nothing is folded."""
        if not self.axes:
            return whole
        mirrors = tuple(1 + n % 2 if a in self.axes else 0 for a, n in enumerate(self.shape))
        return replace(whole, shape=self.half_shape, mirrors=mirrors)

    def half(self, values: NDArray[Any], images: int = 0) -> NDArray[Any]:
        """The kept part of values (..., *shape); not a copy. images: layers more, behind it."""
        ends = (n + images * (a in self.axes) for a, n in enumerate(self.half_shape))
        kept: Any = (..., *map(slice, ends))
        return values[kept]

    def whole(self, values: Values) -> Values:
        """Light (size, *shape) from its half; the same if nothing is folded."""
        parities = self.basis.parities.astype(values.dtype)
        for axis in self.axes:
            images = self.shape[axis] - self.half_shape[axis]
            lower: Any = (slice(None),) * (axis + 1) + (slice(images),)
            signs = parities[:, axis].reshape(-1, *(1,) * len(self.shape))
            values = np.concatenate([values, signs * np.flip(values[lower], axis + 1)], axis + 1)
        return values

    def half_box(self, box: Box) -> Box:
        """The part of a box that is kept."""
        return tuple((first, min(last, n)) for (first, last), n in zip(box, self.half_shape))

    def whole_box(self, box: Box) -> Box:
        """The smallest box round a box and its images."""
        if is_empty(box):
            return box
        return tuple(
            (first, n - first) if axis in self.axes else (first, last)
            for axis, ((first, last), n) in enumerate(zip(box, self.shape))
        )

    def occlusion(self, occlusion: Occlusion) -> Occlusion:
        """What walls do in the half, and τ of the images behind it, too."""
        if not self.axes:
            return occlusion
        tau = occlusion.transmittance
        if tau is not None:
            tau = np.ascontiguousarray(self.half(tau, images=1))
        parts = []
        for part in occlusion.reflections:
            kept = np.all(part.cells < self.half_shape, axis=1)
            parts.append(Reflection(part.cells[kept], np.ascontiguousarray(part.lobes[kept])))
        return replace(occlusion, transmittance=tau, reflections=tuple(parts))


def wall_axes(
    occlusion: Occlusion, stencil: Stencil, shape: tuple[int, ...], axes: Sequence[int]
) -> tuple[int, ...]:
    """Those of some axes of a grid along which its walls are their own mirror image.

    In what a scheme sees of them, to `drawn_rounding`. Axes must be such along which the scheme
    itself is.
    """
    return tuple(axis for axis in axes if _walls_turn(occlusion, stencil, shape, axis))


def _walls_turn(occlusion: Occlusion, stencil: Stencil, shape: tuple[int, ...], axis: int) -> bool:
    images = image_offsets(stencil, axis)
    if images is None:
        return False
    tau = occlusion.transmittance
    if tau is not None:
        for d, image in enumerate(images):
            if np.abs(tau[d] - np.flip(tau[image], axis)).max() > drawn_rounding(shape):
                return False
    signs = stencil.basis.parities[:, axis]
    return all(_turns(part, images, signs, shape, axis) for part in occlusion.reflections)


def _turns(
    reflection: Reflection,
    images: list[int],
    signs: NDArray[np.int64],
    shape: tuple[int, ...],
    axis: int,
) -> bool:
    """Whether cells have images, and send back what those send back, turned round."""
    cells = reflection.cells.copy()
    places = np.ravel_multi_index(tuple(cells.T), shape)
    cells[:, axis] = shape[axis] - 1 - cells[:, axis]
    turned = np.ravel_multi_index(tuple(cells.T), shape)
    own, other = np.argsort(places), np.argsort(turned)
    if not np.array_equal(places[own], turned[other]):
        return False
    lobes = reflection.lobes
    limit = drawn_rounding(shape) * np.abs(lobes).max(initial=0.0)
    difference = lobes[own] - signs * lobes[other][:, images]
    return bool(np.abs(difference).max(initial=0.0) <= limit)
