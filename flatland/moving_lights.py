"""The converged light of many lights among the same walls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from flatland.field import Field
from flatland.scene import Scene
from flatland.simulation import Simulation


def converged_fields(
    simulation: Simulation, scenes: Iterable[Scene], tolerance: float = 1e-8, method: str = "auto"
) -> Iterator[Field]:
    """The converged field of each scene in turn, which differ in their lights alone.

    What only walls and scheme decide, such as blocking, coarse grids and factors, is set up once:
    on 128² cells with 2 bands and a few walls a light takes 10 to 15 ms after the first one's half
    a second. Solved one after another, since more right-hand sides at once were no faster:
    triangular solves with 20 columns take as long as 20 with one, and SciPy's sparse ones longer.

    simulation: takes over the lights of each scene, and is left with those of the last. tolerance
    and method: see `Simulation.solve`. Raises InputError for a scene with another grid or other
    walls, and what `Simulation.solve` raises.
    """
    for scene in scenes:
        simulation.relight(scene)
        simulation.solve(tolerance, method)
        yield simulation.accumulated
