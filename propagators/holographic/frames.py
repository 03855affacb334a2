"""The four quarter turns of a lattice: in each, light is looked for towards +X.

A point (X, Y) of a frame, in lattice steps, is the point (X, Y) of the world turned by the frame's
number of right angles, counter-clockwise, and moved back onto the lattice.
"""

from __future__ import annotations

from propagators.analytic.compiling import inlined


@inlined
def to_world(frame: int, x: float, y: float, width: int, height: int) -> tuple[float, float]:
    """From frame to world. width, height: of the world's lattice, in steps."""
    if frame == 0:
        return x, y
    if frame == 1:
        return width - y, x
    if frame == 2:
        return width - x, height - y
    return y, height - x


@inlined
def cell_in_world(frame: int, i: int, j: int, nx: int, ny: int) -> tuple[int, int]:
    """The same for cells; nx, ny: of the world."""
    if frame == 0:
        return i, j
    if frame == 1:
        return nx - 1 - j, i
    if frame == 2:
        return nx - 1 - i, ny - 1 - j
    return j, ny - 1 - i
