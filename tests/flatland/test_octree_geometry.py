"""Walls on coarse levels: exact ones are cut anew, the geometry volume is downsampled."""

import numpy as np
import pytest
from scenes import LPV, quiet

from flatland.blocking import Surfels, exact_transmittance, surfels_of_segments
from flatland.grid import Grid
from flatland.occlusion import Walls, same_places
from flatland.scene import Scene

SEGMENTS = [
    {"kind": "segment", "start": [2.3, 1.0], "end": [9.1, 7.7]},
    {"kind": "polygon", "vertices": [[10.0, 2.0], [14.0, 2.5], [12.0, 9.0]]},
]


def scene_with(occluders, lights=(), shape=(16, 12)):
    tables = {"grid": {"shape": shape}, "occluder": occluders, "light": list(lights)}
    return Scene.from_dict(tables)


def volume(surfels, nodes):
    """Area at every node, by hand."""
    total = np.zeros(nodes)
    np.add.at(total, tuple(surfels.nodes.T), surfels.areas)
    return total


def random_surfels(rng, dimension, count=40, cells=8):
    nodes = rng.integers(0, cells + 1, size=(count, dimension))
    normals = rng.normal(size=(count, dimension))
    closed = rng.random(count) < 0.5
    return Surfels(nodes, rng.random(count), normals, closed, np.arange(count))


@pytest.mark.parametrize("dimension", [2, 3])
def test_downsampled_geometry_keeps_its_area(dimension, rng):
    """In square metres: sides are twice as long, so faces are 2^(D-1) times as large."""
    fine = random_surfels(rng, dimension)
    coarse = fine.coarsened()
    for wall in range(len(fine.areas)):
        area = coarse.areas[coarse.walls == wall].sum() * 2 ** (dimension - 1)
        assert area == pytest.approx(fine.areas[wall], rel=1e-14)
        np.testing.assert_array_equal(
            coarse.normals[coarse.walls == wall],
            np.tile(fine.normals[wall], ((coarse.walls == wall).sum(), 1)),
        )
    assert coarse.nodes.max() <= 4


@pytest.mark.parametrize("dimension", [2, 3])
def test_coarse_nodes_gather_full_and_half_neighbours(dimension, rng):
    """V(J) = 2^(1-D) Σ_s w_s v(2J + s), w = (1/2, 1, 1/2) along every axis."""
    fine = random_surfels(rng, dimension)
    padded = np.pad(volume(fine, (9,) * dimension), 1)
    expected = np.zeros((5,) * dimension)
    for node in np.ndindex(expected.shape):
        for step in np.ndindex((3,) * dimension):
            weight = np.prod([(0.5, 1.0, 0.5)[s] for s in step])
            place = tuple(2 * j + s for j, s in zip(node, step))  # padded by one
            expected[node] += weight * padded[place] / 2 ** (dimension - 1)
    np.testing.assert_allclose(volume(fine.coarsened(), expected.shape), expected, atol=1e-14)


@pytest.mark.parametrize("start", [0.0, 2.0])
def test_a_wall_on_coarse_grid_lines_is_what_it_is_there(start):
    """Downsampled twice or injected at once into cells four times as large."""
    wall = [{"kind": "segment", "start": [8.0, 4 * start], "end": [8.0, 16.0]}]
    segments = scene_with(wall, shape=(16, 24)).segments()
    direct = surfels_of_segments(Grid((4, 6), 4.0), segments)
    coarse = surfels_of_segments(Grid((16, 24)), segments).coarsened().coarsened()
    np.testing.assert_allclose(volume(coarse, (5, 7)), volume(direct, (5, 7)), atol=1e-14)


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
def test_levels_get_the_walls_of_their_own_grid(blocking):
    scene = scene_with(SEGMENTS)
    simulation = quiet(LPV, scene, levels=3, blocking=blocking, bands=3)
    simulation.start()
    stencil = simulation.stencil
    for number in (1, 2):
        found = simulation.octree.levels[number].occlusion
        expected = Walls(blocking).occlusion(scene, stencil, level=number)
        np.testing.assert_array_equal(found.transmittance, expected.transmittance)
        grid = simulation.level(number).grid
        if blocking == "exact":
            beams = exact_transmittance(grid, scene.segments(), stencil.offsets)
            np.testing.assert_array_equal(found.transmittance, beams)
        assert found.transmittance.shape == (4, *grid.shape)
        assert found.transmittance.min() < 1
        assert found.free_first_step == (blocking == "fuzzy")


def test_light_that_has_moved_before_is_blocked_at_once():
    """The free first step is for light among the surfels that send it."""
    light = {"kind": "cell", "cell": [3, 5], "direction": [1.0, 0.0], "flux": 1.0}
    wall = [{"kind": "segment", "start": [8.0, 0.0], "end": [8.0, 12.0]}]
    simulation = quiet(LPV, scene_with(wall, [light]), levels=2, blocking="fuzzy", bands=3)
    simulation.inject()
    simulation.run(4)
    simulation.downsample_geometry()
    simulation.downsample()
    simulation.run(1)
    assert simulation.level(1).ledger.absorbed > 0


def test_blocking_lights_free_the_cells_they_shine_in_on_every_level():
    """A slanted light: its own cells send as if it were not there."""
    light = {"kind": "area", "start": [9.0, 5.2], "end": [4.0, 3.1], "flux": 1.0}
    scene = scene_with([], [light])
    simulation = quiet(LPV, scene, levels=3, lights_block=True)
    simulation.start()
    cells = scene.lights[0].deposit(scene.grid, simulation.basis).cells
    for number in range(3):
        tau = simulation.octree.levels[number].occlusion.transmittance
        there = tuple(same_places(scene.grid, cells, simulation.level(number).grid))
        np.testing.assert_array_equal(there, np.unique(cells >> number, axis=1))
        for d, offset in enumerate(simulation.stencil.offsets):
            if offset @ scene.lights[0].normal >= 0:
                np.testing.assert_array_equal(tau[(d, *there)], 1.0)
    assert any(level.occlusion.transmittance.min() < 1 for level in simulation.octree.levels)


def test_a_closed_room_on_grid_lines_of_all_levels_is_tight_on_all():
    """Exact blocking; the room is 2 cells wide on level 2."""
    corners = [[4.0, 4.0], [12.0, 4.0], [12.0, 12.0], [4.0, 12.0]]
    light = {"kind": "cell", "cell": [6, 6], "flux": 1.0}
    room = [{"kind": "polygon", "vertices": corners, "albedo": 0.5}]
    simulation = quiet(LPV, scene_with(room, [light], (16, 16)), levels=3, skip=False)
    simulation.run(60)
    for number in range(3):
        field = simulation.level(number).accumulated.scalar_flux()
        low, high = 4 >> number, 12 >> number
        field[low:high, low:high] = 0
        np.testing.assert_array_equal(field, 0)
        ledger = simulation.level(number).ledger
        assert ledger.left == 0
        assert ledger.reflected > 0


def test_places_of_cells_on_other_grids():
    grid = Grid((8, 8), 0.5, (1.0, -2.0))
    cells = np.array([[0, 1, 2, 7, 7], [0, 1, 5, 7, 6]])
    np.testing.assert_array_equal(same_places(grid, cells, grid).T, np.unique(cells.T, axis=0))
    shifted = Grid((3, 3), 1.0, (2.0, 0.0))
    # Cells (2, 5) and (7, 6) have their centres at (2.25, 0.75) and (4.75, 1.25).
    np.testing.assert_array_equal(same_places(grid, cells, shifted).T, [[0, 0], [2, 1]])
