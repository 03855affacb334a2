"""Where the light goes: flux onto whole walls and out of the grid, apart from cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.ledger import Ledger
from propagators.analytic_3d.elements import Elements, cut_border
from propagators.analytic_3d.geometry import Geometry
from propagators.analytic_3d.lighting import direct_light
from propagators.analytic_3d.plates import polygon_area
from propagators.analytic_3d.radiosity import Bounced

Array = NDArray[np.float64]


def arrivals(geometry: Geometry, elements: Elements, tolerance: float) -> Array:
    """Irradiance (2 N, C), in flux per cell face, that lights give sides of elements directly.

    What arrives at the rear of a gate has come in through it.
    """
    sides = 2 * len(elements.areas)
    values = direct_light(geometry, elements.panels(), sides, 1, tolerance)
    flux = values[:, :, 0] * np.sqrt(4 * np.pi)
    gates = np.unique(geometry.surfaces[geometry.gates])
    flux[1::2][np.isin(elements.owners, gates)] = 0.0
    return np.asarray(flux / elements.side_areas[:, None])


def absorbed_flux(geometry: Geometry, elements: Elements, incoming: Array) -> Array:
    """Flux (surfaces, C) that each area light, then each facet absorbs [W].

    A share 1 - albedo of what arrives. Where two lie on one another, the earlier one gets it.
    """
    flux = np.zeros_like(geometry.albedo)
    np.add.at(flux, elements.side_owners, incoming * elements.side_areas[:, None])
    return flux * (1 - geometry.albedo)


def balance(
    geometry: Geometry,
    elements: Elements,
    incoming: Array,
    bounced: Bounced | None,
    tolerance: float,
) -> Ledger:
    """The books of a scene, entries (C,).

    emitted: by lights, and what parallel light brings over the border. left: what crosses the
    border outwards, and what walls on it send outwards. Lights must shine into the grid, as every
    scene's do. Nothing of this is found from anything else in it.
    """
    border = cut_border(geometry)
    values = direct_light(geometry, border, 1, 1, tolerance)
    left = values[0, :, 0] * np.sqrt(4 * np.pi)
    if bounced is not None:
        sent = bounced.radiosity * elements.side_areas[:, None]
        left = left + bounced.open_share @ sent
    absorbed = absorbed_flux(geometry, elements, incoming).sum(axis=0)
    return Ledger(_emitted(geometry), left, absorbed)


def _emitted(geometry: Geometry) -> Array:
    lights = geometry.lights
    plates = [lights.vertices[a:b] for a, b in zip(lights.first[:-1], lights.first[1:])]
    areas = np.array([polygon_area(plate) for plate in plates])
    result = np.pi * areas @ geometry.radiance
    for point in geometry.points:
        unit = np.sqrt(4 * np.pi) * float(np.asarray(point.coefficients)[0])
        lobe = point.lobe_flux if point.lobe_direction is not None else 0.0
        result = result + (unit + lobe) * point.spectrum
    nx, ny, nz = geometry.grid.shape
    for beam, strength in zip(geometry.beams, geometry.irradiances):
        result = result + np.abs(beam.direction) @ [ny * nz, nx * nz, nx * ny] * strength
    return np.asarray(result)
