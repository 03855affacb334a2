"""A scene solved by beams, for one set of ordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.ledger import Ledger
from propagators.beam.bounces import reflected_radiance
from propagators.beam.flight import FadedFlight, Transport
from propagators.maps.flight import Maps
from propagators.maps.generations import settled_light
from propagators.transport.ordinates import Ordinates
from propagators.transport.problem import DirectProblem

Array = NDArray[np.float64]

#: Angles and rays of the maps that carry what a medium scatters: 0.3 to 0.5 % of the field is left,
#: half of that for five times the time.
SCATTERED = 32, 8


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


def first_flight_through(problem: DirectProblem, ordinates: Ordinates) -> FadedFlight:
    """Light of segments through the scene's medium, to its first collision or wall."""
    medium, surfaces = problem.scene.medium, problem.surfaces
    assert medium is not None
    scale = ordinates.emission_scale(surfaces.arrangement.segments)[surfaces.owners]
    transport = Transport(surfaces, ordinates, problem.shape)
    optical = medium.extinction * problem.geometry.grid.spacing
    return transport.fly_through(surfaces.radiance * scale[:, None, None], problem.basis, optical)


def solve_in_medium(problem: DirectProblem, ordinates: Ordinates) -> tuple[Array, Ledger]:
    """The same in a medium: first flight by beams, all that follows by light propagation maps."""
    cells = None
    if problem.sizeless is not None:
        problem, cells = problem.of_segments_only()
    first = first_flight_through(problem, ordinates)
    maps = Maps(problem, *SCATTERED)
    rest = settled_light(maps, cells, first.arrived, first.collided, lights=False)
    emitted = problem.light_flux
    if cells is not None:
        emitted = emitted + cells[:, 0].sum(axis=(1, 2)) * problem.basis.flux_weight
    unsent = np.where(maps.passed > 0, 0.0, rest.sent).sum(axis=(0, 1))
    collided = first.collided.sum(axis=(1, 2)) + rest.tally.collided.sum(axis=(0, 1))
    books = problem.books(
        emitted,
        rest.sent.sum(axis=(0, 1)),
        first.left + rest.tally.left,
        first.arrived + rest.tally.arrived,
        -unsent,
        collided,
        rest.scattered.sum(axis=(1, 2)),
    )
    return first.values + rest.values, books


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
