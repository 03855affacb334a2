"""Fuzzy blocking in 3D: surfels of facets, potentials, symmetry, what leaks."""

from itertools import pairwise

import numpy as np
import pytest
from space import (
    AXIAL,
    CUBE,
    NEIGHBOURS,
    Walls3d,
    box_faces,
    facets,
    moved,
    rotation,
    space_scene,
    sphere_faces,
)

import propagators
from flatland.blocking import fuzzy_transmittance, surfels_of_facets, surfels_of_segments
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.occlusion import Walls
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.sources import Segment

GRID = Grid((7, 6, 5))
#: What is left of a sum of a few hundred products.
ROUNDING = 1e-13
L_SHAPE = [(1, 1, 1.2), (5, 1, 1.2), (5, 2, 1.2), (2, 2, 1.2), (2, 5, 1.2), (1, 5, 1.2)]
#: Through centres, on grid planes, slanted, not convex.
MIXED = [
    [(2.5, 1, 1), (2.5, 4, 1), (2.5, 4, 3.5), (2.5, 1, 3.5)],
    [(3, 2, 4), (6, 2, 4), (6, 5, 4), (3, 5, 4)],
    [(1.2, 0.3, 0.4), (5.9, 2.2, 1.7), (4.1, 5.6, 4.8)],
    L_SHAPE,
]


def fuzzy(walls, bands=2, offsets=AXIAL, strength=1.0, grid=GRID):
    surfels = surfels_of_facets(grid, walls)
    return fuzzy_transmittance(grid.shape, surfels, offsets, basis_for(3, bands), strength)


def across_x(x, y, z):
    """A rectangle at x that spans y and z."""
    return [(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])]


# -- surfels --------------------------------------------------------------------------------------


def test_areas_add_up(rng):
    triangles = rng.uniform(0.2, 4.8, (40, 3, 3))
    surfels = surfels_of_facets(GRID, facets(*triangles))
    sides = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    expected = 0.5 * np.linalg.norm(np.cross(*sides), axis=1)
    found = np.bincount(surfels.walls, surfels.areas, len(triangles))
    np.testing.assert_allclose(found, expected, rtol=1e-11)


def test_a_surfel_belongs_to_the_nearest_corner():
    surfels = surfels_of_facets(GRID, facets([(1.6, 2.3, 4), (1.9, 2.4, 4), (1.7, 2.4, 4.2)]))
    assert set(map(tuple, surfels.nodes)) == {(2, 2, 4)}


def test_a_wall_through_centres_goes_to_both_sides_by_halves():
    surfels = surfels_of_facets(GRID, facets(across_x(2.5, (1.5, 2.5), (0.5, 1.5))))
    order = np.argsort(surfels.nodes[:, 0])
    np.testing.assert_array_equal(surfels.nodes[order], [[2, 2, 1], [3, 2, 1]])
    np.testing.assert_allclose(surfels.areas, 0.5)


def test_a_box_looks_outwards():
    box = {"kind": "box", "min": [2.0, 1.0, 1.0], "max": [5.0, 4.0, 3.0]}
    scene = Scene.from_dict({"grid": {"shape": (7, 6, 5)}, "occluder": [box]})
    surfels = surfels_of_facets(scene.grid, scene.facets())
    assert surfels.closed.all()
    away = surfels.nodes - np.array([3.5, 2.5, 2.0])
    assert np.all(np.sum(away * surfels.normals, axis=1) > 0)
    assert surfels.areas.sum() == pytest.approx(2 * (3 * 3 + 3 * 2 + 3 * 2))


def test_what_has_no_area_and_what_is_far_away_has_no_surfels():
    line = [(1, 1, 1), (2, 2, 2), (3, 3, 3)]
    for walls in ([], facets(line), facets(across_x(30, (1, 2), (1, 2)))):
        assert not surfels_of_facets(GRID, walls).areas.size
        assert fuzzy(walls) is None
    assert fuzzy(facets(*MIXED), strength=0.0) is None


def tall(ends, height):
    """Segments (S, 4) as walls along z."""
    return [
        [(x0, y0, 0), (x1, y1, 0), (x1, y1, height), (x0, y0, height)] for x0, y0, x1, y1 in ends
    ]


TALL = [(1, 2.5, 4.5, 2.5), (3, 3, 3, 5.5), (1.2, 0.4, 2.6, 5.1), (5, 1, 6, 2)]


def test_tall_walls_have_the_surfels_of_2d():
    flat = surfels_of_segments(
        Grid((7, 6)), [Segment(np.array(e[:2]), np.array(e[2:]), np.zeros(1)) for e in TALL]
    )
    deep = surfels_of_facets(GRID, facets(*tall(TALL, 5)))
    expected, found = np.zeros((4, 8, 7)), np.zeros((4, 8, 7, 6))
    np.add.at(expected, (flat.walls, *flat.nodes.T), flat.areas)
    np.add.at(found, (deep.walls, *deep.nodes.T), deep.areas)
    for layer in range(1, 5):
        np.testing.assert_allclose(found[..., layer], expected, atol=ROUNDING)
    for wall, normal in zip(deep.walls, deep.normals):
        known = flat.normals[flat.walls == wall][0]
        assert abs(normal[:2] @ known) == pytest.approx(1.0)


# -- potentials -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bands", "potential"),
    [
        (1, 1 / 4),
        (2, 1 / 4 + 1 / 2),
        (3, 1.0),  # 17/16, clamped
        (5, 1 / 4 + 1 / 2 + 5 / 16 - 3 / 32),
    ],
)
def test_a_wall_on_faces_stops_what_the_bands_can_tell(bands, potential):
    tau = fuzzy(facets(across_x(3, (0, 6), (0, 5))), bands)
    for d, cell in ((5, 2), (0, 3)):
        assert abs(AXIAL[d][0]) == 1
        assert tau[d, cell, 3, 2] == pytest.approx(1 - potential, abs=ROUNDING)


def test_tall_walls_block_as_in_2d_when_bands_are_many():
    """The bases differ, so the same surfels mean the same only in the limit."""
    flat = [step for step in NEIGHBOURS if step[2] == 0]
    deep = fuzzy(facets(*tall(TALL, 5)), 12, flat, strength=0.5)
    segments = [Segment(np.array(e[:2]), np.array(e[2:]), np.zeros(1)) for e in TALL]
    surfels = surfels_of_segments(Grid((7, 6)), segments)
    steps = np.array(flat)[:, :2]
    expected = fuzzy_transmittance((7, 6), surfels, steps, basis_for(2, 24), 0.5)
    for layer in range(1, 4):
        np.testing.assert_allclose(deep[..., layer], expected, atol=0.02)


def test_both_sides_of_a_wall_block_alike():
    tau = fuzzy(facets(*MIXED), 4, NEIGHBOURS)
    for open_share, step in zip(tau, NEIGHBOURS):
        back = tau[int(np.flatnonzero((-step == NEIGHBOURS).all(axis=1))[0])]
        np.testing.assert_allclose(moved(open_share, -step), moved(back, step), atol=ROUNDING)


def test_the_sense_in_which_a_thin_wall_is_drawn_does_not_matter():
    turned = [wall if i % 2 else wall[::-1] for i, wall in enumerate(MIXED)]
    np.testing.assert_allclose(fuzzy(facets(*MIXED)), fuzzy(facets(*turned)), atol=ROUNDING)


def turned(points, matrix):
    """Points of the grid in the grid turned by a symmetry of the cube."""
    return (points - np.array(GRID.shape) / 2) @ matrix.T + np.abs(matrix @ GRID.shape) / 2


@pytest.mark.parametrize("closed", [False, True])
def test_turned_and_mirrored_scenes_have_turned_and_mirrored_shares(closed):
    polygons = [
        np.array(p, float) for p in (box_faces((4, 3, 2), (3, 2.5, 2)) if closed else MIXED)
    ]
    plain = fuzzy(facets(*polygons, closed=closed), 3, NEIGHBOURS)
    cells = np.argwhere(np.ones(GRID.shape))
    for matrix in CUBE:
        shape = np.abs(matrix @ GRID.shape)
        # A mirrored outline runs the other way round.
        sense = round(np.linalg.det(matrix))
        walls = facets(*(turned(polygon, matrix)[::sense] for polygon in polygons), closed=closed)
        found = fuzzy(walls, 3, NEIGHBOURS @ matrix.T, grid=Grid(tuple(shape.tolist())))
        there = np.floor(turned(cells + 0.5, matrix)).astype(int)
        expected = plain.reshape(len(plain), -1)
        np.testing.assert_allclose(found[(slice(None), *there.T)], expected, atol=ROUNDING)


def test_strength_multiplies_what_is_stopped():
    piece = facets(across_x(3, (1.2, 2.0), (1, 2)))
    weak, plain = fuzzy(piece, strength=0.5), fuzzy(piece)
    np.testing.assert_allclose(1 - weak, 0.5 * (1 - plain), atol=ROUNDING)


def test_a_mesh_blocks_like_the_ball_it_stands_for():
    """Finer triangles, the same potentials."""
    grid, middle = Grid((9, 9, 9)), np.full(3, 4.5)
    coarse, fine = (
        fuzzy(facets(*sphere_faces(middle, 3.0, n), closed=True), 3, grid=grid) for n in (3, 4)
    )
    assert coarse.min() < 0.2
    np.testing.assert_allclose(coarse, fine, atol=0.02)


# -- in a run -------------------------------------------------------------------------------------


def run_of(scheme, faces, strength, bands=2):
    light = {"kind": "cell", "cell": [6, 6, 6], "flux": 1.0}
    scene = space_scene(Walls3d(tuple(faces), closed=True), shape=(13, 12, 12), light=light)
    propagator = propagators.create(scheme)
    run = Simulation(scene, propagator, bands=bands, blocking="fuzzy", strength=strength)
    run.run(80)
    return run


TURNED = box_faces((6.5, 6, 6), (6.5, 6, 7), rotation(np.random.default_rng(3)))


@pytest.mark.parametrize("scheme", ["lpv", "dom6", "dom26"])
def test_fuzzy_walls_leak_less_with_strength(scheme):
    strengths = (0.0, 0.5, 1.0, 2.0, 4.0)
    leaks = [float(run_of(scheme, TURNED, strength).ledger.left) for strength in strengths]
    message = ", ".join(f"{s:g}: {value:.4f}" for s, value in zip(strengths, leaks))
    assert leaks[0] > 0.6, message
    assert all(b < a for a, b in pairwise(leaks)), message
    assert leaks[4] < 0.05, message


@pytest.mark.parametrize("scheme", ["lpv", "dom6"])
def test_a_strong_wall_on_faces_is_tight_for_axial_steps(scheme):
    """Two bands stop 3/4 of what meets a face head-on: a strength of 4/3 stops all of it."""
    faces = box_faces((6, 6, 6), (8, 8, 8))
    assert run_of(scheme, faces, 1.0).ledger.left > 0.05
    # Faces beside an edge of the box have surfels of less than their area: twice as much will do.
    assert run_of(scheme, faces, 8 / 3).ledger.left == pytest.approx(0.0, abs=1e-12)


def test_the_first_step_is_free_and_the_second_is_not():
    scene = space_scene(
        Walls3d((across_x(6, (3, 9), (3, 9)),)),
        shape=(13, 12, 12),
        light={"kind": "cell", "cell": [5, 6, 6], "flux": 1.0},
    )
    run = Simulation(scene, propagators.create("dom6"), blocking="fuzzy")
    run.step()
    assert run.ledger.absorbed == 0
    run.step()
    assert run.ledger.absorbed > 0.01


# -- lights that block ----------------------------------------------------------------------------


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
def test_a_light_that_blocks_does_not_stop_its_own_light(blocking):
    square = [(3, 3, 5), (9, 3, 5), (9, 9, 5), (3, 9, 5)]
    light = {"kind": "area", "vertices": square, "flux": 1.0}
    scene = space_scene(shape=(12, 12, 12), light=light)
    (lamp,) = scene.lights
    stencil = propagators.create("dom26").stencil(basis_for(3, 2))
    found = Walls(blocking, lights_block=True).occlusion(scene, stencil)
    assert Walls(blocking).occlusion(scene, stencil).transmittance is None
    cells = tuple(lamp.deposit(scene.grid, stencil.basis).cells)
    front = stencil.offsets[:, 2] >= 0
    assert np.all(found.transmittance[front][:, *cells] == 1)
    down = int(np.flatnonzero((stencil.offsets == (0, 0, -1)).all(axis=1))[0])
    assert np.all(found.transmittance[(down, *cells)] < 0.8)
    assert found.reflections == ()
