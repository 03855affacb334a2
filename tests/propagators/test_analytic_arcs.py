"""Analytic reference: the arcs at a point, against rays cast backwards."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene
from test_analytic_montecarlo import nearest_hit

from flatland.errors import InputError
from propagators.analytic import Analytic

POINTS = np.random.default_rng(5).uniform(0.2, 7.8, (12, 2)).tolist()


def seen_light(point, angles):
    """Which light (or -1) sends light that travels at each angle through the point."""
    ways = -np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    origins = np.broadcast_to(point, ways.shape)
    segments = [(a, b) for a, b, *_ in (*LIGHTS, *WALLS)]
    hits = np.stack([nearest_hit(origins, ways, [segment]) for segment in segments])
    first = np.where(np.isfinite(hits.min(axis=0)), hits.argmin(axis=0), -1)
    for k, (a, b, _) in enumerate(LIGHTS):
        extent = np.subtract(b, a)
        rear = extent[0] * -ways[:, 1] - extent[1] * -ways[:, 0] <= 0
        first[(first == k) & rear] = -1
    return np.where(first < len(LIGHTS), first, -1)


@pytest.mark.parametrize("point", POINTS)
def test_arcs_are_where_rays_find_a_light(point):
    angles = (np.arange(20000) + 0.5) * (2 * np.pi / 20000) - np.pi
    from_arcs = np.full(angles.size, -1)
    edges = []
    for arc in Analytic().arcs(make_scene(), point):
        assert -np.pi < arc.start <= np.pi
        assert arc.start < arc.stop < arc.start + np.pi
        from_arcs[(angles - arc.start) % (2 * np.pi) < arc.stop - arc.start] = arc.emitter
        edges += [arc.start, arc.stop]
    wrong = angles[from_arcs != seen_light(point, angles)]
    # Only the angles next to an edge may differ, by rounding.
    near = [np.min(np.abs((np.array(edges) - a + np.pi) % (2 * np.pi) - np.pi)) for a in wrong]
    assert np.all(np.array(near) < 1e-9)


def test_radiance_is_flux_by_twice_the_length():
    scene = make_scene(lights=[((1, 1), (3, 1), 4.0)], walls=(), spacing=0.5)
    (arc,) = Analytic().arcs(scene, (1.0, 1.5))
    assert arc.radiance == pytest.approx(4 / (2 * 1.0))
    assert (arc.start, arc.stop) == pytest.approx(
        (np.pi / 2 - np.arctan(0.5), np.pi / 2 + np.arctan(0.5))
    )


def test_a_coloured_arc_has_a_radiance_per_colour():
    (arc,) = Analytic().arcs(make_scene(lights=[((1, 1), (3, 1), [4.0, 2.0])], walls=()), (2, 3))
    np.testing.assert_allclose(arc.radiance, [1, 0.5])


def test_behind_a_light_is_nothing():
    assert Analytic().arcs(make_scene(lights=[((1, 1), (3, 1), 4.0)], walls=()), (2, 0.5)) == []


def test_a_point_on_a_wall_sees_both_sides():
    lights = [((1, 1), (3, 1), 1.0), ((3, 7), (1, 7), 1.0)]
    arcs = Analytic().arcs(make_scene(lights=lights, walls=[((0, 4), (4, 4))]), (2, 4))
    assert {arc.emitter for arc in arcs} == {0, 1}


@pytest.mark.parametrize("point", [(1, 2, 3), (np.nan, 0), 4])
def test_a_point_has_two_finite_coordinates(point):
    with pytest.raises(InputError, match="point"):
        Analytic().arcs(make_scene(), point)
