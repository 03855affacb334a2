"""How far rays get: borders, walls, and walls that touch."""

import numpy as np
import pytest
import trimesh
from walls3d import GRID, facet, facets, first_hits, random_polygon

from flatland.grid import Grid
from flatland.rays import free_lengths
from flatland.sources import Segment

FLAT = Grid((16, 12), 0.5, (1.0, -2.0))


def segment(start, stop):
    return Segment(FLAT.to_world(start), FLAT.to_world(stop), np.array(0.5))


def length(origin, direction, walls=(), grid=FLAT):
    """Free length in cells."""
    way = np.array([direction], float)
    way /= np.linalg.norm(way)
    return float(free_lengths(grid, walls, grid.to_world([origin]), way)[0]) / grid.spacing


def test_without_walls_rays_reach_the_border():
    assert length((3, 4), (1, 0)) == pytest.approx(13)
    assert length((3, 4), (-3, -4)) == pytest.approx(5)
    assert length((3, 4, 5), (0, 0, -1), grid=GRID) == pytest.approx(5)
    assert length((0, 4), (-1, 0)) == 0
    assert length((0, 4), (1, 0)) == pytest.approx(16)


def test_a_wall_that_the_ray_starts_on_does_not_stop_it():
    wall = segment((2, 4), (9, 4))
    assert length((3, 4), (0, 1), [wall]) == pytest.approx(8)
    assert length((3, 3), (0, 1), [wall]) == pytest.approx(1)
    assert length((3, 4), (1, 0), [wall]) == pytest.approx(13)


def test_rays_through_shared_ends_and_edges_are_stopped():
    corner = [segment((8, 2), (8, 5)), segment((8, 5), (8, 9))]
    assert length((3, 5), (1, 0), corner) == pytest.approx(5)
    halves = [facet([(8, 2, 2), (8, 6, 2), (8, 6, 6)]), facet([(8, 2, 2), (8, 6, 6), (8, 2, 6)])]
    for place in (2.5, 3.0, 4.1):
        assert length((3, place, place), (1, 0, 0), halves, GRID) == pytest.approx(5)
    assert length((3, 7, 3), (1, 0, 0), halves, GRID) == pytest.approx(13)


@pytest.mark.parametrize("snapped", [False, True])
def test_lengths_agree_with_brute_force(rng, snapped):
    polygons = [random_polygon(rng, snapped) for _ in range(12)]
    origins = rng.uniform((0, 0, 0), GRID.shape, (20_000, 3))
    ways = rng.normal(size=origins.shape)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    _, expected = first_hits(origins, ways, polygons)
    found = free_lengths(GRID, facets(polygons), GRID.to_world(origins), ways) / GRID.spacing
    border = free_lengths(GRID, [], GRID.to_world(origins), ways) / GRID.spacing
    np.testing.assert_allclose(found, np.minimum(expected, border), atol=1e-6)
    assert np.mean(found < border) > 0.2


def test_no_ray_leaves_a_closed_mesh(rng):
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=4.0)
    walls = [facet(triangle) for triangle in mesh.triangles + np.array([8, 6, 5])]
    ways = rng.normal(size=(5000, 3))
    # To corners and middles of edges, where triangles touch, too.
    ways = np.concatenate([ways, mesh.vertices, mesh.vertices[mesh.edges].mean(axis=1)])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    origins = np.tile(GRID.to_world((8, 6, 5)), (len(ways), 1))
    assert free_lengths(GRID, walls, origins, ways).max() <= 4.0 * GRID.spacing + 1e-12
