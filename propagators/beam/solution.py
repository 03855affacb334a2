"""A scene solved by beams, for one set of ordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.ledger import Ledger
from propagators.beam.bounces import reflected_radiance
from propagators.beam.flight import Transport
from propagators.transport.ordinates import Ordinates
from propagators.transport.problem import DirectProblem

Array = NDArray[np.float64]


def solve_by_beams(problem: DirectProblem, ordinates: Ordinates) -> tuple[Array, Ledger]:
    """Coefficients (C, size, nx, ny) of segment lights and walls, and all books, entries (C,)."""
    surfaces = problem.surfaces
    transport = Transport(surfaces, ordinates, problem.shape)
    scale = ordinates.emission_scale(surfaces.arrangement.segments)[surfaces.owners]
    radiance = surfaces.radiance * scale[:, None, None]
    emitted = None
    if surfaces.arrangement.reflects:
        direct = transport.fly(radiance, None)
        emitted = direct.emitted
        arrived = direct.arrived + problem.sizeless_flux
        radiance = radiance + reflected_radiance(transport, scale, arrived)
    flight = transport.fly(radiance, problem.basis)
    emitted = flight.emitted if emitted is None else emitted
    reflected = flight.emitted - emitted
    books = problem.books(emitted, reflected, flight.left, flight.arrived, 0 * emitted)
    return flight.values, books


def surface_radiance(problem: DirectProblem, ordinates: Ordinates) -> Array:
    """Radiance (E, 2, C) of all sides, lights and walls, for schemes that only carry it."""
    surfaces = problem.surfaces
    if not surfaces.arrangement.reflects:
        return surfaces.radiance
    transport = Transport(surfaces, ordinates, problem.shape)
    scale = ordinates.emission_scale(surfaces.arrangement.segments)[surfaces.owners]
    direct = transport.fly(surfaces.radiance * scale[:, None, None], None)
    arrived = direct.arrived + problem.sizeless_flux
    reflected = reflected_radiance(transport, scale, arrived) / scale[:, None, None]
    return surfaces.radiance + reflected


def intensity_by_beams(problem: DirectProblem, directions: Array) -> Array:
    """Intensity (C, K, nx, ny) of the segment lights at directions (K, 2), one by one."""
    transport = Transport(problem.surfaces, Ordinates(4), problem.shape)
    radiance = problem.surfaces.radiance
    values = [transport.along(direction, radiance) for direction in directions]
    return np.array(values).reshape(-1, problem.colours, *problem.shape).swapaxes(0, 1)
