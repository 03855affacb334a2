"""Analytic reference with bounces: agreement with paths traced at random, by other geometry."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene
from test_analytic_montecarlo import SIZE, crossings, emitted_rays, nearest_hit

from propagators.analytic import Analytic

ALBEDO = 0.8
BATCHES, BOUNCES = 30, 25
#: 4 harmonics in 64 cells: the largest of 256 deviates of Student's t with 29 degrees of freedom
#: exceeds 5.5 once in 600 times.
LARGEST_DEVIATE = 5.5


@pytest.fixture(scope="module")
def estimate():
    """Mean and standard error (4, 8, 8) of four harmonics, from independent batches of paths."""
    rng = np.random.default_rng(77)
    batches = np.array([one_batch(rng, 8_000) for _ in range(BATCHES)])
    return batches.mean(axis=0), batches.std(axis=0, ddof=1) / np.sqrt(BATCHES)


def one_batch(rng, paths):
    scores = np.zeros((4, SIZE, SIZE))
    for light in LIGHTS:
        origins, ways = (each[:paths] for each in emitted_rays(light, rng))
        for _ in range(BOUNCES):
            hits = np.stack([nearest_hit(origins, ways, [segment]) for segment in SEGMENTS])
            reach = hits.min(axis=0)
            score(scores, origins, ways, reach, light[2] / paths)
            wall = hits.argmin(axis=0)
            lives = np.isfinite(reach) & (wall >= len(LIGHTS)) & (rng.random(len(reach)) < ALBEDO)
            origins = (origins + np.where(lives, reach, 0)[:, None] * ways)[lives]
            ways = reflected(ways[lives], wall[lives], rng)
        assert len(origins) < 0.01 * paths
    return scores


SEGMENTS = [(a, b) for a, b, *_ in (*LIGHTS, *WALLS)]


def score(scores, origins, ways, reach, weight):
    angle = np.arctan2(ways[:, 1], ways[:, 0])
    functions = np.stack([0 * angle + 1, np.cos(angle), np.sin(2 * angle), np.cos(5 * angle)])
    for cells, rays in crossings(origins, ways, reach):
        for k, function in enumerate(functions[:, rays]):
            np.add.at(scores[k], cells, weight * function)


def reflected(ways, wall, rng):
    """Lambertian directions on the side of the walls that the rays came from."""
    along = np.array([np.subtract(b, a) / np.hypot(*np.subtract(b, a)) for a, b in SEGMENTS])[wall]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    normal *= -np.sign(np.einsum("kd,kd->k", normal, ways))[:, None]
    sine = rng.uniform(-1, 1, (len(ways), 1))
    return sine * along + np.sqrt(1 - sine**2) * normal


def exact(**options):
    values = Analytic(**options).solve(make_scene(albedo=ALBEDO), 6).values
    scale = np.sqrt(np.pi) * np.array([np.sqrt(2), 1, 1, 1])
    return scale[:, None, None] * values[[0, 1, 4, 9]]


def test_fields_with_bounces_lie_within_the_statistical_error(estimate):
    mean, error = estimate
    deviate = (mean - exact(element=0.25)) / np.where(error > 0, error, np.inf)
    assert np.abs(deviate).max() < LARGEST_DEVIATE
    assert 0.6 < np.mean(deviate[error > 0] ** 2) < 1.6


def test_the_statistical_error_would_show_a_missing_bounce(estimate):
    mean, error = estimate
    deviate = (mean - exact(bounces=False)) / np.where(error > 0, error, np.inf)
    assert np.mean(deviate[error > 0] ** 2) > 50
