"""What is its own mirror image: angular bases, schemes, light."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil

Array = NDArray[np.float64]
Values = NDArray[np.floating]

_EPSILON = float(np.finfo(float).eps)
#: Numbers of a scheme that differ by no more than this part of the largest are the same but for the
#: way they were computed; images in built-in schemes differ by 7 ulp.
ROUNDING = 64 * _EPSILON


def drawn_rounding(shape: Sequence[int]) -> float:
    """The same for what walls and lights on a grid make of their corners.

    A corner at n cells is known to n ulp of a cell, and a share of a beam changes by as much as the
    corner does: scenes that are drawn symmetric are so to that, and no better. Measured: 27 ulp on
    48 x 32 cells (lobes round polygons with 24 corners), 200 on 256 x 256.
    """
    return ROUNDING + 2 * max(shape) * _EPSILON


def is_mirror_symmetric(stencil: Stencil) -> bool:
    """Whether the scheme treats every direction and its mirror image alike, but for 1e-10 of it."""
    return len(scheme_axes(stencil, 1e-10)) == stencil.basis.dimension


def scheme_axes(stencil: Stencil, tolerance: float = ROUNDING) -> tuple[int, ...]:
    """Axes along which a scheme, turned round, is the same.

    tolerance: part of its largest number. A clamped scheme must have the same faces, in any order.
    """
    axes = range(stencil.basis.dimension)
    return tuple(axis for axis in axes if _turns(stencil, axis, tolerance))


def image_offsets(stencil: Stencil, axis: int) -> list[int] | None:
    """Which offset each one becomes when an axis is turned round; None if one has no image."""
    offsets = [tuple(offset) for offset in stencil.offsets.tolist()]
    images = [tuple(-v if a == axis else v for a, v in enumerate(o)) for o in offsets]
    return [offsets.index(o) for o in images] if set(images) <= set(offsets) else None


def _turns(stencil: Stencil, axis: int, tolerance: float) -> bool:
    images = image_offsets(stencil, axis)
    if images is None:
        return False
    signs = stencil.basis.parities[:, axis]
    transfer = stencil.transfer
    limit = tolerance * np.abs(transfer).max(initial=0.0)
    if np.abs(np.outer(signs, signs) * transfer - transfer[images]).max(initial=0.0) > limit:
        return False
    return not stencil.clamp or _faces_turn(stencil, images, signs, tolerance)


def _faces_turn(
    stencil: Stencil, images: list[int], signs: NDArray[np.int64], tolerance: float
) -> bool:
    """Whether each face of an offset is the image of another one of the offset's image."""
    assert stencil.reception is not None
    assert stencil.emission is not None
    emission = np.swapaxes(stencil.emission, 1, 2)
    # Numbers of the lobes and of what they are the answer to, in units of the largest of each.
    parts = [part / np.abs(part).max() for part in (stencil.reception, emission)]
    for d, image in enumerate(images):
        left = list(range(parts[0].shape[1]))
        for face in range(parts[0].shape[1]):
            for other in left:
                pairs = ((part[d, face] * signs, part[image, other]) for part in parts)
                if all(np.abs(a - b).max() <= tolerance for a, b in pairs):
                    left.remove(other)
                    break
            else:
                return False
    return True


def light_axes(
    values: Values, basis: AngularBasis, axes: Iterable[int], tolerance: float
) -> tuple[int, ...]:
    """Those of some axes along which light (size, *shape) is its own mirror image.

    tolerance: part of its largest coefficient, at least two units of its last digit.
    """
    signs = basis.parities
    largest = float(max(values.max(initial=0.0), -values.min(initial=0.0)))
    limit = largest * max(tolerance, 2 * float(np.finfo(values.dtype).eps))
    return tuple(axis for axis in axes if _is_own_image(values, signs[:, axis], axis, limit))


def _is_own_image(values: Values, signs: NDArray[np.int64], axis: int, limit: float) -> bool:
    """Component by component, so that most light that is not is found out early."""
    kept = -(-values.shape[axis + 1] // 2)
    for component, sign in zip(values, signs):
        light = np.moveaxis(component, axis, 0)
        lower, upper = light[:kept], light[::-1][:kept]
        difference = lower - upper if sign > 0 else lower + upper
        if max(difference.max(initial=0.0), -difference.min(initial=0.0)) > limit:
            return False
    return True
