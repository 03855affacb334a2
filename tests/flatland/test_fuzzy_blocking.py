"""Fuzzy blocking: surfels, symmetry, what leaks; and walls that lights are."""

from itertools import pairwise

import numpy as np
import pytest
from books import assert_same_books
from scenes import assert_same_state

import propagators
from flatland.blocking import exact_transmittance, fuzzy_transmittance, surfels_of_segments
from flatland.blocking.surfels import outward_sides
from flatland.errors import InputError
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.sources import Segment

GRID = Grid((7, 7))
AXIAL = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
ALL = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
EAST, NORTH, WEST = 0, 1, 2
#: What is left of a sum of a few hundred products.
ROUNDING = 1e-13
TILTED = [[6.0, 1.3], [10.7, 5.2], [6.1, 9.7], [1.2, 5.1]]
STRAIGHT = [[2.0, 2.0], [9.0, 2.0], [9.0, 8.0], [2.0, 8.0]]


def walls(*ends):
    return [Segment(np.array(e[:2], float), np.array(e[2:], float), np.zeros(1)) for e in ends]


def outline(vertices):
    return walls(*np.concatenate([vertices, np.roll(vertices, -1, axis=0)], axis=1))


def fuzzy(segments, bands=2, offsets=AXIAL, strength=1.0, grid=GRID):
    basis = basis_for(2, bands)
    return fuzzy_transmittance(
        grid.shape, surfels_of_segments(grid, segments), offsets, basis, strength
    )


def box_scene(vertices, *, inside=True, flux=2.0, shape=(12, 11), **wall):
    light = {"kind": "cell", "cell": [5, 5] if inside else [0, 0], "flux": flux}
    occluder = {"kind": "polygon", "vertices": vertices, **wall}
    return Scene.from_dict({"grid": {"shape": shape}, "light": [light], "occluder": [occluder]})


def outside_of(scene, vertices):
    """Cells whose centres lie outside a convex polygon with corners counter-clockwise."""
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in scene.grid.shape), indexing="ij"))
    result = np.zeros(scene.grid.shape, bool)
    for (x0, y0), (x1, y1) in zip(vertices, [*vertices[1:], vertices[0]]):
        result |= (x1 - x0) * (centres[1] - y0) - (y1 - y0) * (centres[0] - x0) < 0
    return result


# -- surfels --------------------------------------------------------------------------------------


def test_lengths_add_up(rng):
    ends = rng.uniform(0.2, 6.8, (40, 4))
    surfels = surfels_of_segments(GRID, walls(*ends))
    lengths = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1])
    found = np.bincount(surfels.walls, surfels.areas, len(ends))
    np.testing.assert_allclose(found, lengths, rtol=1e-12)


def test_a_surfel_belongs_to_the_nearest_corner():
    surfels = surfels_of_segments(GRID, walls((1.6, 2.3, 1.9, 2.4)))
    np.testing.assert_array_equal(surfels.nodes, [[2, 2], [2, 2]])


def test_a_wall_through_centres_goes_to_both_sides_by_halves():
    surfels = surfels_of_segments(GRID, walls((2.5, 1.5, 2.5, 2.5)))
    order = np.argsort(surfels.nodes[:, 0])
    np.testing.assert_array_equal(surfels.nodes[order], [[2, 2], [3, 2]])
    np.testing.assert_allclose(surfels.areas, 0.5)


@pytest.mark.parametrize("turn", [1, -1])
def test_a_closed_outline_looks_outwards_whatever_its_sense(turn):
    segments = [*walls((0, 0, 1, 0)), *outline(np.array([(2, 2), (5, 2), (3, 4)])[::turn])]
    assert outward_sides(segments) == [0, -turn, -turn, -turn]
    surfels = surfels_of_segments(GRID, segments)
    away = surfels.nodes[surfels.closed] - np.array([10 / 3, 8 / 3])
    outwards = np.sum(away * surfels.normals[surfels.closed], axis=1)
    assert np.average(outwards > 0, weights=surfels.areas[surfels.closed]) > 0.9


# -- potentials -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bands", "potential"),
    [
        (1, 1 / np.pi),
        (2, 1 / np.pi + 1 / 2),
        (3, 1.0),  # 1.03, clamped
        (5, 1 / np.pi + 1 / 2 + 2 / (3 * np.pi) - 2 / (15 * np.pi)),
    ],
)
def test_a_wall_on_faces_stops_what_the_bands_can_tell(bands, potential):
    tau, passing = fuzzy(walls((3, 0, 3, 7)), bands), 1 - potential
    np.testing.assert_allclose(tau[[EAST, WEST], [2, 3], 3], passing, atol=ROUNDING)


def test_both_sides_of_a_wall_block_alike():
    tau = fuzzy(walls((2.2, 1.1, 4.3, 5.2), (4.3, 5.2, 6.0, 1.0)), 4, ALL)
    for d, step in enumerate(ALL):
        back = int(np.flatnonzero((-step == ALL).all(axis=1))[0])
        for cell in np.ndindex(GRID.shape):
            goal = tuple(cell + step)
            if min(goal) >= 0 and max(goal) < 7:
                assert tau[(d, *cell)] == pytest.approx(tau[(back, *goal)], abs=ROUNDING)


def test_the_sense_in_which_a_thin_wall_is_drawn_does_not_matter():
    pieces = walls((1, 3, 3, 3.4), (3, 3.4, 6, 3.1))
    turned = [pieces[0], Segment(pieces[1].stop, pieces[1].start, pieces[1].albedo)]
    np.testing.assert_allclose(fuzzy(pieces), fuzzy(turned), atol=ROUNDING)


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_turned_scene_has_turned_shares(turns, mirrored):
    """Walls through centres and on grid lines too."""
    ends = np.array([(1, 2.5, 4.5, 2.5), (3, 3, 3, 6), (1.2, 5, 2.6, 6.1), (5, 1, 6, 2)]) - 3.5
    matrix = np.linalg.matrix_power(np.array([[0, -1], [1, 0]]), turns)
    matrix = matrix @ np.diag([-1 if mirrored else 1, 1])
    moved = (ends.reshape(-1, 2) @ matrix.T).reshape(-1, 4) + 3.5
    first, second = fuzzy(walls(*(ends + 3.5)), 3, ALL), fuzzy(walls(*moved), 3, ALL)
    for d, step in enumerate(ALL):
        turned = int(np.flatnonzero((matrix @ step == ALL).all(axis=1))[0])
        for cell in np.ndindex(GRID.shape):
            goal = np.rint(matrix @ (np.array(cell) - 3) + 3).astype(int)
            same = second[(turned, *goal)]
            assert first[(d, *cell)] == pytest.approx(same, abs=ROUNDING)


def test_strength_multiplies_what_is_stopped():
    piece = walls((3, 1.2, 3, 2.0))
    weak, plain = fuzzy(piece, strength=0.5), fuzzy(piece)
    np.testing.assert_allclose(1 - weak, 0.5 * (1 - plain), atol=ROUNDING)


@pytest.mark.parametrize("strength", [-1.0, np.nan, np.inf])
def test_a_strength_that_is_none_is_refused(strength):
    with pytest.raises(InputError, match="strength"):
        Simulation(box_scene(STRAIGHT), propagators.create("lpv"), strength=strength)


def test_no_surfels_no_geometry_volume():
    assert fuzzy([]) is None
    assert fuzzy(walls((30, 1, 31, 2))) is None
    assert fuzzy(walls((3, 1, 3, 2)), strength=0.0) is None


# -- in a run -------------------------------------------------------------------------------------


def test_without_occluders_nothing_changes_bit_for_bit():
    light = {"kind": "cell", "cell": [3, 4], "flux": 1.0}
    scene = Scene.from_dict({"grid": {"shape": (9, 8)}, "light": [light]})
    states = []
    for blocking in ("none", "fuzzy", "exact"):
        simulation = Simulation(scene, propagators.create("dom8"), bands=3, blocking=blocking)
        assert simulation._occlusion.transmittance is None
        simulation.run(12)
        states.append(simulation)
    assert_same_state(states[0], states[1])
    assert_same_state(states[0], states[2])


def test_the_first_step_is_free_and_the_second_is_not():
    scene, scheme = box_scene([[5.0, 5.0], [6.0, 5.0], [6.0, 6.0], [5.0, 6.0]]), "dom4"
    runs = [Simulation(scene, propagators.create(scheme), blocking=b) for b in ("fuzzy", "none")]
    for run in runs:
        run.step()
    assert_same_state(*runs)
    assert runs[0].ledger.absorbed == 0
    for run in runs:
        run.step()
    assert runs[0].ledger.absorbed > 0.01
    assert not np.array_equal(runs[0].target.values, runs[1].target.values)


@pytest.mark.parametrize("scheme", ["lpv", "dom8"])
def test_solving_equals_stepping(scheme):
    scene = box_scene(TILTED, albedo=0.4)
    stepped, solved = (
        Simulation(scene, propagators.create(scheme), blocking="fuzzy") for _ in range(2)
    )
    stepped.run(1500)
    solved.solve(1e-10)
    np.testing.assert_allclose(solved.accumulated.values, stepped.accumulated.values, atol=1e-8)
    entries = ("emitted", "left", "absorbed", "reflected")
    assert_same_books(solved.ledger, stepped.ledger, entries, within=1e-7)


@pytest.mark.parametrize("scheme", ["lpv", "dom4", "dom8"])
@pytest.mark.parametrize("bands", [1, 2, 3, 5])
@pytest.mark.parametrize("vertices", [STRAIGHT, TILTED], ids=["straight", "tilted"])
@pytest.mark.parametrize("inside", [True, False])
def test_exact_walls_let_exactly_nothing_through(scheme, bands, vertices, inside):
    scene = box_scene(vertices, inside=inside, albedo=0.6)
    simulation = Simulation(scene, propagators.create(scheme), bands=bands)
    simulation.run(60)
    flux = simulation.accumulated.values[0]
    reached = flux != 0
    assert reached[5, 5] == inside
    assert reached[0, 0] != inside
    if inside:
        # A cell that a slanted wall cuts may have its centre on either side: look further out.
        far = outside_of(scene, (np.array(vertices) - 6) * 1.25 + 6)
        assert not reached[far].any()
        assert simulation.ledger.left == 0
    else:
        assert not reached[4:7, 4:7].any()


@pytest.mark.parametrize("scheme", ["lpv", "dom4", "dom8"])
def test_fuzzy_walls_leak_less_with_strength_up_to_a_point(scheme):
    def leak(strength):
        run = Simulation(
            box_scene(TILTED), propagators.create(scheme), blocking="fuzzy", strength=strength
        )
        run.solve()
        return float(run.ledger.left / run.ledger.emitted)

    strengths = (0.0, 0.5, 1.0, 1.5, 2.0, 4.0, 8.0)
    leaks = [leak(strength) for strength in strengths]
    message = ", ".join(f"{s:g}: {value:.4f}" for s, value in zip(strengths, leaks))
    assert leaks[0] == pytest.approx(1.0, abs=1e-6), message
    assert all(b < a for a, b in pairwise(leaks[:5])), message
    assert leaks[4] < 0.35, message
    # Once every face it has surfels near is shut, more strength changes nothing.
    assert leaks[5] == pytest.approx(leaks[6], abs=0.02), message


# -- lights that block ----------------------------------------------------------------------------


def lamp_scene(end=(9.0, 6.0)):
    """A segment that emits upwards, and light that comes down on it."""
    return Scene.from_dict(
        {
            "grid": {"shape": (12, 12)},
            "light": [
                {"kind": "area", "start": [3.0, 5.0], "end": end, "flux": 2.0},
                {"kind": "wall", "side": "top", "flux": 1.0},
            ],
        }
    )


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
@pytest.mark.parametrize("end", [(9.0, 5.0), (9.0, 6.7)])
def test_a_light_that_blocks_does_not_stop_its_own_light(blocking, end):
    options = {"bands": 3, "blocking": blocking, "lights_block": True}
    simulation = Simulation(lamp_scene(end), propagators.create("dom8"), **options)
    free = Simulation(lamp_scene(end), propagators.create("dom8"), bands=3)
    light = simulation.scene.lights[0]
    cells = tuple(light.deposit(simulation.scene.grid, simulation.basis).cells)
    front = simulation.stencil.offsets @ light.normal > 0
    tau = simulation._occlusion.transmittance
    assert np.all(tau[front][:, *cells] == 1)
    assert free._occlusion.transmittance is None
    for run in (simulation, free):
        run.solve()
    assert simulation.ledger.absorbed > 0.05
    below = np.s_[0, 4:8, :4]
    assert simulation.accumulated.values[below].sum() < 0.6 * free.accumulated.values[below].sum()


def test_exact_blocking_by_a_light_is_that_of_a_wall_for_other_light():
    scene = lamp_scene((9.0, 5.0))
    simulation = Simulation(scene, propagators.create("dom4"), lights_block=True)
    expected = exact_transmittance(scene.grid, walls((3, 5, 9, 5)), simulation.stencil.offsets)
    np.testing.assert_array_equal(simulation._occlusion.transmittance, expected)
