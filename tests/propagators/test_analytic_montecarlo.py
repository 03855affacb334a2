"""Analytic reference: agreement with rays cast at random, with their own geometry code."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene

from propagators.analytic import Analytic

RAYS = 200_000
SIZE = 8
#: 4 harmonics in 64 cells: the largest of 256 normal deviates exceeds 4.5 once in 600 times.
LARGEST_DEVIATE = 4.5


@pytest.fixture(scope="module")
def estimate():
    """Mean and standard error (4, 8, 8) of the flux and of three harmonics that leave each cell."""
    rng = np.random.default_rng(2024)
    mean, variance = np.zeros((4, SIZE, SIZE)), np.zeros((4, SIZE, SIZE))
    for light in LIGHTS:
        origins, ways = emitted_rays(light, rng)
        reach = nearest_hit(origins, ways, [(a, b) for a, b, *_ in (*LIGHTS, *WALLS)])
        angle = np.arctan2(ways[:, 1], ways[:, 0])
        functions = np.stack([0 * angle + 1, np.cos(angle), np.sin(2 * angle), np.cos(5 * angle)])
        for cells, rays in crossings(origins, ways, reach):
            # A ray leaves a cell at most once, so that its score there is function or 0.
            for k, function in enumerate(functions[:, rays]):
                np.add.at(mean[k], cells, light[2] * function / RAYS)
                np.add.at(variance[k], cells, (light[2] * function) ** 2 / RAYS**2)
    return mean, np.sqrt(variance)


def emitted_rays(light, rng):
    """Lambertian rays: uniform along the light, sine of the angle to the normal uniform."""
    start, extent = np.array(light[0]), np.subtract(light[1], light[0])
    along = extent / np.hypot(*extent)
    sine = rng.uniform(-1, 1, (RAYS, 1))
    ways = sine * along + np.sqrt(1 - sine**2) * np.array([-along[1], along[0]])
    return start + rng.random((RAYS, 1)) * extent, ways


def nearest_hit(origins, ways, segments):
    reach = np.full(len(origins), np.inf)
    for a, b in segments:
        extent, offset = np.subtract(b, a), np.array(a) - origins
        across = ways[:, 0] * extent[1] - ways[:, 1] * extent[0]
        distance = (offset[:, 0] * extent[1] - offset[:, 1] * extent[0]) / across
        share = (offset[:, 0] * ways[:, 1] - offset[:, 1] * ways[:, 0]) / across
        hit = (distance > 1e-9) & (share >= 0) & (share <= 1)
        reach = np.where(hit & (distance < reach), distance, reach)
    return reach


def crossings(origins, ways, reach):
    """For every grid line: the cells that rays leave over it, and which rays."""
    for axis in (0, 1):
        for line in range(SIZE + 1):
            distance = (line - origins[:, axis]) / ways[:, axis]
            rays = np.flatnonzero((distance > 0) & (distance <= reach))
            place = origins[rays] + distance[rays, None] * ways[rays]
            cells = np.floor(place).astype(int)
            cells[:, axis] = np.where(ways[rays, axis] > 0, line - 1, line)
            inside = np.all((cells >= 0) & (cells < SIZE), axis=1)
            yield tuple(cells[inside].T), rays[inside]


def exact():
    values = Analytic().solve(make_scene(), 6).values
    scale = np.sqrt(np.pi) * np.array([np.sqrt(2), 1, 1, 1])
    return scale[:, None, None] * values[[0, 1, 4, 9]]


def test_flux_and_harmonics_lie_within_the_statistical_error(estimate):
    mean, error = estimate
    deviate = (mean - exact()) / np.where(error > 0, error, np.inf)
    assert np.abs(deviate).max() < LARGEST_DEVIATE


def test_deviates_have_unit_variance(estimate):
    mean, error = estimate
    deviate = ((mean - exact()) / np.where(error > 0, error, np.inf))[error > 0]
    # Cells share rays, so the sum of squares scatters more than chi-squared does.
    assert 0.6 < np.mean(deviate**2) < 1.5


def test_cells_that_no_ray_reaches_are_dark(estimate):
    mean, _ = estimate
    assert np.abs(exact()[0][mean[0] == 0]).max() < 1e-4
