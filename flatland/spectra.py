"""What of a scene's light is stepped: spectra, the memory for them, and their range."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.injection import independent_spectra, inject, most_spectra
from flatland.kernels import Layout
from flatland.memory import require_memory
from flatland.occlusion import Occlusion, without_first_bounces
from flatland.patch import Patch
from flatland.scene import Scene
from flatland.stencil import Stencil

Array = NDArray[np.float64]


def spectra_of(scene: Scene, stencil: Stencil, occlusion: Occlusion) -> tuple[list[Patch], Array]:
    """The P patterns of light that are stepped, and mixing (colours, P)."""
    lights = without_first_bounces(scene) if occlusion.reflections else scene
    if not (stencil.clamp or occlusion.coloured):
        patterns, mixing = independent_spectra(lights, stencil.basis)
        return [Patch.around(pattern) for pattern in patterns], mixing
    # A clamped step is not linear, and coloured walls treat every colour in their own way:
    # every colour goes alone.
    values = inject(lights, stencil.basis).values
    values = values if scene.colours else values[None]
    return [Patch.around(colour) for colour in values], np.eye(len(values))


def require_room(
    scene: Scene, stencil: Stencil, grids: Sequence[Grid], precision: str, blocked: bool
) -> None:
    """Refuse grids whose fields would not fit in memory.

    Three per spectrum and level, and the pattern of light that it starts from in float64; what
    walls leave open of each link, in float64 and as the sweep reads it.
    """
    spectra = max(1, scene.colours) if stencil.clamp else most_spectra(scene)
    number, basis = np.dtype(precision), stencil.basis
    layouts = [Layout(grid.shape, basis.size, number) for grid in grids]
    fields = 3 * number.itemsize * sum(layout.size for layout in layouts)
    needed = spectra * (fields + 8 * layouts[0].size)
    if blocked:
        links = len(stencil.offsets) * sum(grid.cell_count for grid in grids)
        needed += links * (number.itemsize + 8)
    if scene.medium is not None:
        # What stays in each cell, by offset, and as the sweep reads it.
        size, offsets = basis.size, len(stencil.offsets)
        cells = sum(grid.cell_count for grid in grids)
        needed += 8 * cells * size * (2 * offsets + min(size, offsets))
    require_memory(needed, "grid.shape", scene.grid.shape)


def require_range(mixing: Array, scales: Sequence[float], precision: str) -> None:
    """Refuse light that the precision cannot hold, with a million to spare either way."""
    size = float((np.abs(mixing) * np.array(scales)).max())
    limits = np.finfo(precision)
    if not 1e6 * float(limits.tiny) < size < 1e-6 * float(limits.max):
        rule = f"cannot hold light of about {size:.0e} per unit angle"
        raise bad_input("precision", precision, rule, ("float64",))
