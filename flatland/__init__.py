"""The engine: grid, angular bases, scenes, lights, stencils and the simulation that steps them."""

from flatland.cascades import Cascade
from flatland.errors import (
    ConvergenceError,
    FlatlandError,
    InputError,
    InstabilityError,
    SchemeWarning,
)
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from flatland.ledger import Ledger
from flatland.moving_lights import converged_fields
from flatland.scene import Scene, load_scene
from flatland.simulation import Simulation
from flatland.stencil import Stencil

__all__ = [
    "Cascade",
    "CircularHarmonics",
    "ConvergenceError",
    "Field",
    "FlatlandError",
    "Grid",
    "InputError",
    "InstabilityError",
    "Ledger",
    "Scene",
    "SchemeWarning",
    "Simulation",
    "SphericalHarmonics",
    "Stencil",
    "converged_fields",
    "load_scene",
]
