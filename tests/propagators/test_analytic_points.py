"""Analytic reference: light of points."""

from types import SimpleNamespace

import numpy as np
import pytest
from analytic_scenes import WALLS, make_scene

from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics
from flatland.sources import PointSource, Segment
from propagators.analytic import Analytic

CELL = {"kind": "cell", "cell": [3, 3], "flux": 2.0}
LOBE = {**CELL, "direction": [0.6, 0.8]}


def test_an_isotropic_point_sends_each_cell_the_share_of_the_angle_it_fills():
    scene = make_scene(lights=(), walls=(), points=[CELL])
    flux = Analytic().solve(scene, 1).scalar_flux()
    angle = np.zeros((8, 8))
    for (i, j), _ in np.ndenumerate(angle):
        corners = [(i + a - 3.5, j + b - 3.5) for a in (0, 1) for b in (0, 1)]
        seen = np.angle(
            np.array([x + 1j * y for x, y in corners]) / complex(i - 3, j - 3 or 1e-300)
        )
        angle[i, j] = np.ptp(seen)
    angle[3, 3] = 2 * np.pi
    np.testing.assert_allclose(flux, angle / np.pi, rtol=0, atol=1e-12)


@pytest.mark.parametrize("point", [CELL, LOBE])
def test_flux_of_points_leaves_or_is_absorbed(point):
    ledger = Analytic().energy(make_scene(lights=(), points=[point]))
    assert ledger.emitted == pytest.approx(2)
    assert abs(ledger.closure) < 1e-12
    assert ledger.absorbed > 0.1


def test_a_lobe_is_the_limit_of_a_short_light():
    way = 5e-7 * np.array([0.8, -0.6])
    short = [(3.5 - way, 3.5 + way, 2.0)]
    light, lobe = (
        Analytic().solve(scene, 6).values
        for scene in (make_scene(lights=short), make_scene(lights=(), points=[LOBE]))
    )
    # Where an edge's shadow falls moves by the length of the light.
    np.testing.assert_allclose(light, lobe, rtol=0, atol=2e-6)


def test_a_light_shades_a_point():
    light = ((2, 5), (5, 5), 1.0)
    alone, shaded, point = (
        Analytic().solve(make_scene(lights=lights, walls=(), points=points), 1).values[0]
        for lights, points in (([light], []), ([light], [CELL]), ([], [CELL]))
    )
    from_point = shaded - alone
    assert from_point[3, 6] == pytest.approx(0, abs=1e-15)
    np.testing.assert_allclose(from_point[:, :4], point[:, :4], rtol=0, atol=1e-15)


def series_scene(coefficients, walls=()):
    source = PointSource(np.array([0.4, 0.7]), np.ones(1), coefficients)
    segments = [Segment(np.array(a), np.array(b), np.zeros(1)) for a, b in walls]
    return SimpleNamespace(
        grid=Grid((1, 1)),
        colours=0,
        medium=None,
        sources=lambda part: [source],
        segments=lambda: segments,
    )


def test_a_harmonic_series_passes_through_its_cell_unchanged():
    series = np.random.default_rng(1).normal(size=9)
    values = Analytic().solve(series_scene(series), 8).values[:, 0, 0]
    np.testing.assert_allclose(values, np.pad(series, (0, 6)), rtol=0, atol=1e-14)


def test_a_wall_takes_its_arc_out_of_the_series():
    series = np.random.default_rng(2).normal(size=9)
    wall = ((0.6, 0.7), (0.4, 0.9))
    values = Analytic().solve(series_scene(series, [wall]), 5).values[:, 0, 0]
    hidden = CircularHarmonics(5).arc_gram(0, np.pi / 2) @ series
    np.testing.assert_allclose(values, series - hidden, rtol=0, atol=1e-14)


def test_a_wall_through_a_point_hides_nothing():
    series = np.random.default_rng(3).normal(size=5)
    scene, free = series_scene(series, [((0.2, 0.6), (0.6, 0.8))]), series_scene(series)
    values = Analytic().solve(scene, 3).values[:, 0, 0]
    np.testing.assert_allclose(values, series, rtol=0, atol=1e-14)
    directions = [[0.6, 0.8], [-1, 0], [0, -1]]
    intensities = (Analytic().intensity(each, directions) for each in (scene, free))
    np.testing.assert_allclose(*intensities)


def test_intensity_of_a_point_counts_in_every_cell_its_ray_leaves():
    scene = make_scene(lights=(), walls=[((5.2, 0), (5.2, 8))], points=[CELL])
    intensity = Analytic().intensity(scene, [[1, 0], [0, -1]])
    expected = np.zeros((2, 8, 8))
    expected[0, 3:5, 3] = expected[1, 3, :4] = 2 / (2 * np.pi)
    np.testing.assert_allclose(intensity, expected, rtol=0, atol=1e-15)


def test_intensity_of_points_adds_up_to_their_coefficients():
    scene = make_scene(lights=(), walls=WALLS, points=[LOBE])
    angles = (np.arange(8192) + 0.5) * (2 * np.pi / 8192)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    weights = CircularHarmonics(4).evaluate(directions).T * (2 * np.pi / 8192)
    values = np.tensordot(weights, Analytic().intensity(scene, directions), 1)
    # A ray counts in a cell or does not: first order in the angle between rays.
    np.testing.assert_allclose(values, Analytic().solve(scene, 4).values, rtol=0, atol=2e-3)
