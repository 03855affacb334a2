"""What a run left out because its scene does not need it, and how much work that saved."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatland.kernels.arrivals import written_operations

if TYPE_CHECKING:
    from flatland.simulation import Simulation


@dataclass(frozen=True)
class Skip:
    """Something that was not done. saved: part of the work that it would have been, if known.

    Each part is of what the skips before it left to do.
    """

    name: str
    reason: str
    saved: float | None = None


def skipped(simulation: Simulation) -> list[Skip]:
    """All that a simulation has skipped so far."""
    parts = (_spectra, _walls, _couplings, _levels, _images, _cells, _light)
    return [skip for part in parts for skip in part(simulation)]


def _spectra(simulation: Simulation) -> Iterator[Skip]:
    colours, stepped = simulation.scene.colours, len(simulation.octree.levels[0].states)
    if stepped < colours:
        reason = f"{colours} colours are mixes of {stepped}: light is linear"
        yield Skip("spectra", reason, 1 - stepped / colours)


def _walls(simulation: Simulation) -> Iterator[Skip]:
    occlusion = simulation.octree.levels[0].occlusion
    if occlusion.transmittance is None:
        why = "no wall is in the way" if simulation.scene.walls() else "the scene has no occluders"
        yield Skip("blocking", f"{why}: no geometry volume, no factor per link")
    else:
        shut = float(np.mean(occlusion.transmittance < 1))
        yield Skip("beams", f"{1 - shut:.1%} of all links are open, and were not cut")
        if not occlusion.reflections:
            yield Skip("bounces", "walls send nothing back")
        else:
            cells = len(occlusion.reflections[0].cells)
            count = simulation.scene.grid.cell_count
            reason = f"{cells} of {count} cells lie at walls that send light back"
            yield Skip("bounces", reason, 1 - cells / count)


def _couplings(simulation: Simulation) -> Iterator[Skip]:
    stencil = simulation.stencil
    written = written_operations(stencil)
    if written < stencil.transfer.size and not stencil.clamp:
        reason = (
            f"{written} operations a cell instead of {stencil.transfer.size}: zeros are left out, "
            "neighbours that are mirror images are added up first"
        )
        yield Skip("couplings", reason, 1 - written / stencil.transfer.size)


def _levels(simulation: Simulation) -> Iterator[Skip]:
    levels = simulation.octree.levels
    idle = [n for n, level in enumerate(levels) if level.iteration == 0 and not level.solved]
    if simulation.iteration and idle and len(levels) > 1:
        numbers = ", ".join(map(str, idle))
        work = [level.grid.cell_count for level in levels]
        reason = f"nothing reads level {numbers}" if len(idle) == 1 else f"nothing reads {numbers}"
        yield Skip("levels", reason, sum(work[n] for n in idle) / sum(work))


def _images(simulation: Simulation) -> Iterator[Skip]:
    stepped = [level for level in simulation.octree.levels if level.iteration]
    folded = [level for level in stepped if level.light.fold.axes]
    if folded:
        names = " and ".join("xyz"[axis] for axis in folded[0].light.fold.axes)
        kept = sum(math.prod(level.light.fold.half_shape) for level in stepped)
        whole = sum(level.grid.cell_count for level in stepped)
        reason = f"light and walls are their own mirror image along {names}"
        yield Skip("images", reason, 1 - kept / whole)


def _cells(simulation: Simulation) -> Iterator[Skip]:
    states = [state for level in simulation.octree.levels for state in level.states]
    swept, sweepable = sum(s.swept for s in states), sum(s.sweepable for s in states)
    if swept < sweepable:
        reason = "light has not come to, or has left, the rest of the grid"
        yield Skip("cells", reason, 1 - swept / sweepable)


def _light(simulation: Simulation) -> Iterator[Skip]:
    drop = simulation.octree.rules.drop
    if drop:
        ledger = simulation.ledger
        flux = float(np.sum(np.abs(ledger.dropped)))
        share = flux / max(float(np.sum(ledger.emitted)), np.finfo(float).tiny)
        yield Skip("light", f"below {drop:g} of the brightest: {share:.2g} of the flux, booked")
