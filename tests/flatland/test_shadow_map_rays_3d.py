"""Shadow maps in 3D against rays, one by one, and in rooms that let nothing out."""

import numpy as np
import pytest
import trimesh
from shadow_maps import received
from walls3d import GRID, facet, facets, first_hits, normal_of, point_map, random_polygon, sun_map

from flatland.occluders import BoxOccluder

RAYS = 60_000


def front_cells(points, directions, owner, polygons):
    """The cell half a cell before each point (K, 3), counted from (-2, -2, -2)."""
    normals = np.array([normal_of(polygon) for polygon in polygons])[owner]
    normals *= -np.sign(np.sum(normals * directions, axis=1))[:, None]
    # On a border the cell in front counts.
    return np.floor(points + 0.5 * normals + 1e-9 * normals).astype(int) + 2


def assert_agrees(shadow_map, owner, points, directions, polygons, unit):
    """Flux per wall and per cell against rays of flux `unit` each, to five standard errors."""
    walls = np.bincount(owner[owner >= 0], minlength=len(polygons))
    found = received(shadow_map, polygons) / unit
    assert np.all(np.abs(found - walls) < 5 * np.sqrt(walls) + 5)
    lit = owner >= 0
    shape = np.array(GRID.shape) + 4
    expected, cells = np.zeros(shape), np.zeros(shape)
    places = front_cells(points[lit], directions[lit], owner[lit], polygons)
    np.add.at(expected, tuple(places.T), 1.0)
    np.add.at(cells, tuple(shadow_map.cells.T + 2), shadow_map.received / unit)
    assert np.all(np.abs(cells - expected) < 6 * np.sqrt(cells) + 6)


@pytest.mark.parametrize("snapped", [False, True])
def test_point_light_agrees_with_rays(rng, snapped):
    rays = rng.normal(size=(RAYS, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    for _ in range(8):
        polygons = [random_polygon(rng, snapped) for _ in range(rng.integers(1, 16))]
        position = rng.uniform(1, 9, 3)
        owner, distance = first_hits(np.tile(position, (RAYS, 1)), rays, polygons)
        points = position + distance[:, None] * rays
        found = point_map(facets(polygons), position, 32)
        assert_agrees(found, owner, points, rays, polygons, 1 / RAYS)


@pytest.mark.parametrize("snapped", [False, True])
def test_directional_light_agrees_with_rays(rng, snapped):
    size = np.linalg.norm(GRID.shape) + 1
    for _ in range(8):
        polygons = [random_polygon(rng, snapped) for _ in range(rng.integers(1, 16))]
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        frame = np.linalg.svd(direction[None])[2][1:]
        places = rng.uniform(-size / 2, size / 2, (RAYS, 2)) @ frame + np.array(GRID.shape) / 2
        rays = np.tile(direction, (RAYS, 1))
        owner, distance = first_hits(places - 100 * direction, rays, polygons)
        points = places - 100 * direction + distance[:, None] * direction
        unit = size**2 * GRID.spacing**2 / RAYS
        found = sun_map(facets(polygons), direction, 32)
        assert_agrees(found, owner, points, rays, polygons, unit)


def test_closed_mesh_with_shared_edges_lets_nothing_escape(rng):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=4.5)
    triangles = mesh.triangles * rng.uniform(0.9, 1.1) + (8, 6, 5)
    assert abs(point_map([facet(t) for t in triangles], (8.01, 6.02, 5.3), 16).escaped) < 1e-12


def box_faces(lower, upper):
    """The six faces of a box, in cells."""
    box = BoxOccluder.model_validate({"kind": "box", "min": lower, "max": upper})
    return [face.vertices for face in box.walls()]


def test_room_of_boxes_that_overlap_and_touch_lets_nothing_escape(rng):
    nx, ny, nz = GRID.shape
    room = box_faces((0.0, 0.0, 0.0), (float(nx), float(ny), float(nz)))
    for _ in range(30):
        polygons = list(room)
        for lower in rng.integers(0, 16, (rng.integers(0, 9), 3)) / 2:
            # On cell borders and middles, so that faces coincide.
            polygons += box_faces(tuple(lower), tuple(lower + rng.integers(1, 9, 3) / 2))
        position = rng.integers(1, 37, 3) / 4 + 0.01
        assert abs(point_map(facets(polygons), position, 5).escaped) < 1e-12
        direction = rng.integers(-3, 4, 3) + np.array([0, 0, 0.5])
        assert abs(sun_map(facets(polygons), direction, 5).escaped) < 1e-11
