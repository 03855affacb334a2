"""Exact blocking in 3D: a closed opaque wall lets exactly nothing through."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from space import (
    AXIAL,
    NEIGHBOURS,
    box_faces,
    centres_of,
    connected,
    facets,
    on_surface,
    rotation,
    sphere_faces,
    triangles_of,
    winding,
)

from flatland.blocking import exact_transmittance
from flatland.blocking.exact import beams
from flatland.grid import Grid

SHAPE = (9, 9, 9)
MIDDLE = np.full(3, 4.5)


def turned_box(generator):
    """Quads in general position."""
    centre = MIDDLE + generator.normal(size=3)
    return box_faces(centre, generator.uniform(1, 7, 3), rotation(generator))


def turned_box_of_triangles(generator):
    return triangles_of(turned_box(generator))


def straight_box(generator):
    """Faces on cell borders and through centres, edges along centre rays."""
    centre = MIDDLE + generator.integers(-3, 4, 3) / 2
    return box_faces(centre, generator.integers(2, 12, 3) / 2)


def box_along_diagonals(generator):
    """Turned by 45 degrees about one or two axes, its corners on a lattice."""
    matrix = np.eye(3)
    for axis in generator.permutation(3)[: generator.integers(1, 3)]:
        plane = [k for k in range(3) if k != axis]
        turn = np.eye(3)
        turn[np.ix_(plane, plane)] = np.sqrt(0.5) * np.array([[1, -1], [1, 1]])
        matrix = turn @ matrix
    sizes = generator.choice(np.array([1, 2, 3, np.sqrt(2), np.sqrt(8)]), 3)
    return box_faces(generator.integers(6, 13, 3) / 2, 2 * sizes, matrix)


def hull(generator, points):
    """Triangles round points."""
    found = ConvexHull(points)
    triangles = points[found.simplices]
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inwards = np.sum(across * found.equations[:, :3], axis=1) < 0
    triangles[inwards] = triangles[inwards, ::-1]
    return triangles


def crystal(generator):
    return hull(generator, generator.uniform(0.5, 8.5, (generator.integers(5, 14), 3)))


def crystal_on_the_lattice(generator):
    """Corners on centres, corners and middles of faces and edges of cells."""
    return hull(generator, generator.integers(1, 18, (generator.integers(6, 12), 3)) / 2)


def crumpled(generator):
    """A closed surface with corners on the lattice that passes through itself."""
    triangles = sphere_faces(np.zeros(3), 1.0, subdivisions=0)
    corners, place = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    places = generator.integers(1, 18, corners.shape) / 2
    return places[place.ravel()].reshape(triangles.shape)


def crumpled_on_centres(generator):
    """The same, with many edges along centre rays and corners on centres."""
    return np.floor(2 * crumpled(generator) / 6) * 3 + 1.5


def ball(generator):
    """A mesh of small triangles."""
    return sphere_faces(
        MIDDLE + generator.integers(-1, 2, 3) / 2, generator.uniform(1.5, 4), 2, rotation(generator)
    )


def ball_hit_on_its_corners(generator):
    """Centre rays along the axes hit corners and edges of the mesh exactly."""
    return sphere_faces(MIDDLE, generator.integers(2, 5), 2)


SHAPES = (
    turned_box,
    turned_box_of_triangles,
    straight_box,
    box_along_diagonals,
    crystal,
    crystal_on_the_lattice,
    crumpled,
    crumpled_on_centres,
    ball,
    ball_hit_on_its_corners,
)
MESHES = (ball, ball_hit_on_its_corners)


@pytest.mark.parametrize("offsets", [AXIAL, NEIGHBOURS], ids=["6", "26"])
@pytest.mark.parametrize("shape", SHAPES)
def test_no_light_gets_through_a_closed_wall(shape, offsets):
    generator, grid = np.random.default_rng(11), Grid(SHAPE)
    centres = centres_of(SHAPE)
    enclosed = 0
    for _ in range(2 if shape in MESHES else 6):
        polygons = shape(generator)
        tau = exact_transmittance(grid, facets(*polygons), offsets)
        triangles = triangles_of(polygons)
        odd, on = winding(centres, triangles) % 2 == 1, on_surface(centres, triangles)
        region = connected(tau, offsets)
        enclosed += np.count_nonzero(odd & ~on)
        assert not np.intersect1d(region[odd & ~on], region[~odd & ~on]).size
    assert enclosed > 5


def test_without_walls_between_them_cells_stay_connected():
    """The wall is tight because it is there: both sides of it are whole."""
    faces = box_faces(MIDDLE, (5.3, 4.7, 6.1), rotation(np.random.default_rng(2)))
    tau = exact_transmittance(Grid(SHAPE), facets(*faces), NEIGHBOURS)
    assert len(np.unique(connected(tau, NEIGHBOURS))) == 2


def test_areas_alone_would_leak():
    """What the centre-ray rule is for."""
    faces = facets(*box_faces(MIDDLE, (5.3, 4.7, 6.1), rotation(np.random.default_rng(2))))
    grid = Grid(SHAPE)
    forwards = NEIGHBOURS[13:]
    tau = np.ones((13, *SHAPE))
    for open_share, step in zip(tau, forwards):
        covers = beams(grid, faces).covers(step).within(SHAPE)
        np.subtract.at(open_share, tuple(covers.cells.T), covers.shares)
    assert len(np.unique(connected(np.maximum(tau - 1e-9, 0), forwards))) == 1
