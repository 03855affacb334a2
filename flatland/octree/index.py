r"""The index volume: which level a place is read from.

::

    injected   . . . . . . X . | . . . . . . . .    one cell, left of the octree's middle

    finest     3 3 3 3 2 2 0 1 | 4 4 4 4 4 4 4 4    4: nothing but the root has light there
    symmetric  3 3 3 2 2 1 0 1 | 2 2 3 3 3 3 4 4    rings that double, wherever the borders lie

The octree thesis (4.2) keeps I_i(x) = i for elements of level i that have received light and reads
I(x) = min_i I_i(x), "finest" here; where no level has light it is the coarsest. How fast I falls
off depends on where in the tree the light happens to lie (its figure 17). The thesis proposes (7.1)
to let I grow radially instead, without a formula. "symmetric" is this project's:

    I(x) = min_i ( i + ⌈log₂(1 + d_i(x) / 2^i)⌉ ),

with d_i(x) the distance, in cells of level 0 and with diagonals as long as sides, to what level i
has reached. It is never above "finest" (d_i = 0 there), and between neighbours, diagonal ones
included, it differs by one at most: each term does. What it gets wrong: it may read elements that
light has not reached yet, which are dark. With a scheme that sends to all neighbours, in the open,
there are none from the second step on: level m reaches k 2^m, and what is read from it lies within
(k + 1) 2^i − 1 + 2^m − 2^i of the source for an i < m.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt

from flatland.octree.downsampling import spread

Index = NDArray[np.int8]
Mask = NDArray[np.bool_]

INDEX_STRATEGIES = ("finest", "symmetric")


def level_index(reached: Sequence[Mask], strategy: str = "finest") -> Index:
    """I(x) on the cells of level 0, (*shape), 0 to levels − 1.

    reached: per level, which elements have received light.
    """
    return _finest(reached) if strategy == "finest" else _symmetric(reached)


def _finest(reached: Sequence[Mask]) -> Index:
    last = len(reached) - 1
    index = np.full(reached[-1].shape, last, np.int8)
    for level in range(last - 1, -1, -1):
        mask = reached[level]
        index = np.where(mask, np.int8(level), spread(index, 1, mask.shape))
    return index


def _symmetric(reached: Sequence[Mask]) -> Index:
    last = len(reached) - 1
    shape = reached[0].shape
    index = np.full(shape, last, np.int8)
    for level, mask in enumerate(reached):
        if mask.any():
            distance = distance_transform_cdt(~spread(mask, level, shape), metric="chessboard")
            rings = np.ceil(np.log2(1 + distance / 2**level)).astype(np.int8)
            np.minimum(index, level + rings, out=index)
    return index
