"""Light that walls in 3D send back: nothing gained, nothing lost, every colour by itself."""

import numpy as np
import pytest
from books import assert_same_books, assert_same_colour
from space import CUBE, Walls3d, box_faces, rotation, space_scene, sphere_faces, triangles_of

import flatland.kernels.reflection
import propagators
from flatland.blocking import exact_reflection, exact_transmittance
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.simulation import Simulation

SHAPE = (11, 10, 9)
FLUX = 2.0
ROUNDING = 1e-12
LIGHT = {"kind": "cell", "cell": [5, 5, 4], "direction": [1.0, 0.3, -0.4], "flux": FLUX}
STRAIGHT = tuple(box_faces((5, 5, 4.5), (6, 5, 5)))
TURNED = tuple(box_faces((5.4, 5.1, 4.6), (5.5, 4.5, 5), rotation(np.random.default_rng(4))))
MESH = tuple(sphere_faces((5.5, 5.5, 4.5), 3.4, 1))
#: In an open grid, crossing one another and the border, one of them not convex.
LOOSE = (
    [(1, 2, 0), (6.3, 2.4, 0), (6.3, 2.4, 6), (1, 2, 6)],
    [(8.2, 0.5, 1), (7.1, 6.2, 2), (9.3, 7.0, 7.5)],
    [(-1, 8.2, -1), (5, 9.5, -1), (5, 9.5, 12), (-1, 8.2, 12)],
    [(2, 4, 2.2), (9, 4, 2.2), (9, 5, 2.2), (4, 5, 2.2), (4, 8, 2.2), (2, 8, 2.2)],
    [(3, 1, 4.5), (12, 1, 4.5), (12, 12, 4.5)],
)

every_kind = pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
schemes = pytest.mark.parametrize("scheme", ["lpv", "dom6", "dom26"])
surfaces = pytest.mark.parametrize("walls", [STRAIGHT, TURNED, MESH], ids=["box", "turned", "mesh"])


def scene_of(walls, albedo, light=LIGHT):
    return space_scene(Walls3d(walls, albedo), shape=SHAPE, light=light)


def simulate(scene, scheme="lpv", **arguments):
    return Simulation(scene, propagators.create(scheme), **arguments)


# -- books ----------------------------------------------------------------------------------------


@every_kind
@schemes
@pytest.mark.parametrize(("bands", "precision"), [(1, "float64"), (3, "float64"), (2, "float32")])
def test_books_close_and_flux_never_grows(blocking, scheme, bands, precision):
    """With 3 bands a ringing intensity sends some negative flux to a wall: the light may then
    exceed that of the step before, but never what was emitted."""
    run = simulate(
        scene_of(LOOSE, 0.8), scheme, bands=bands, blocking=blocking, precision=precision
    )
    rounding = ROUNDING if precision == "float64" else 1e-5
    run.inject()
    before = FLUX
    for _ in range(25):
        run.step()
        books = run.ledger
        assert abs(books.closure) < rounding
        arrived = float(run.target.values[0].sum()) * run.basis.flux_weight
        assert books.inside == pytest.approx(arrived, abs=rounding)
        assert books.inside <= before + rounding
        before = books.inside if bands == 1 else FLUX
    assert run.ledger.reflected > 0.1


@every_kind
def test_absorbed_is_what_was_stopped_and_not_sent_back(blocking):
    """The same entries from plain arrays, step by step."""
    run = simulate(scene_of(LOOSE, 0.8), "dom26", blocking=blocking)
    tau, rows = run._occlusion.transmittance, run.stencil.transfer[:, 0, :]
    stopped = 0.0
    run.inject()
    for step in range(12):
        flux = np.tensordot(rows, run.target.values, 1) * run.basis.flux_weight
        if step or not run._occlusion.free_first_step:
            stopped += float(((1 - tau) * flux).sum())
        run.step()
        assert stopped - run.ledger.reflected == pytest.approx(run.ledger.absorbed, abs=ROUNDING)
    assert run.ledger.absorbed == pytest.approx(0.2 * stopped, rel=1e-9)


@schemes
@pytest.mark.parametrize("bands", [1, 2, 4])
@surfaces
def test_a_white_closed_wall_keeps_all_light(scheme, bands, walls):
    run = simulate(scene_of(walls, 1.0), scheme, bands=bands)
    run.run(60)
    assert run.ledger.inside == pytest.approx(FLUX, rel=ROUNDING)
    assert run.ledger.left == 0
    assert run.ledger.absorbed == pytest.approx(0.0, abs=ROUNDING)


@schemes
@surfaces
def test_a_black_closed_wall_lets_exactly_nothing_through(scheme, walls):
    run = simulate(scene_of(walls, 0.0), scheme, bands=2)
    run.run(40)
    assert run.ledger.left == 0
    far = run.accumulated.values[:, 0], run.accumulated.values[:, -1]
    assert not np.any(far)


@schemes
@pytest.mark.parametrize("albedo", [0.3, 0.9])
def test_furnace(scheme, albedo):
    """Every wall gets Φ, then ρΦ, ρ²Φ, …: Φ/(1 − ρ) in all, and keeps Φ."""
    run = simulate(scene_of(TURNED, albedo), scheme)
    run.solve(1e-11)
    assert run.ledger.absorbed == pytest.approx(FLUX, rel=1e-8)
    received = run.ledger.absorbed + run.ledger.reflected
    assert received == pytest.approx(FLUX / (1 - albedo), rel=1e-8)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_both_ways_to_keep_a_reflection_send_the_same_back(precision, monkeypatch):
    """By what coefficients make of it, as 26 neighbours do it, and by the flux of every link."""
    runs = []
    for few in (flatland.kernels.reflection._FEW, 10**6):
        monkeypatch.setattr(flatland.kernels.reflection, "_FEW", few)
        runs.append(simulate(scene_of(LOOSE, 0.8), "dom26", precision=precision))
        runs[-1].run(20)
    by_blocks = [run.octree.levels[0]._sweeps[0]._reflector._by_blocks for run in runs]
    assert by_blocks == [True, False]
    rounding = {"float64": 1e-14, "float32": 1e-6}[precision]
    first, second = (run.accumulated.values for run in runs)
    np.testing.assert_allclose(first, second, rtol=0, atol=rounding)
    reflected = [float(run.ledger.reflected) for run in runs]
    assert reflected[0] == pytest.approx(reflected[1], rel=rounding * 10)


# -- the converged field --------------------------------------------------------------------------


@every_kind
@schemes
def test_solving_equals_stepping(blocking, scheme):
    stepped, solved = (simulate(scene_of(LOOSE, 0.7), scheme, blocking=blocking) for _ in range(2))
    stepped.run(700)
    report = solved.solve(1e-11)
    np.testing.assert_allclose(
        solved.accumulated.values, stepped.accumulated.values, atol=1e-9, err_msg=report.method
    )
    entries = ("emitted", "left", "absorbed", "reflected")
    assert_same_books(solved.ledger, stepped.ledger, entries, within=1e-8)


@every_kind
@pytest.mark.parametrize("method", ["multigrid", "krylov", "stepping"])
def test_all_methods_know_of_walls_and_bounces(blocking, method):
    scene = scene_of(LOOSE, 0.7)
    expected = simulate(scene, blocking=blocking)
    expected.run(700)
    run = simulate(scene, blocking=blocking)
    assert run.solve(1e-10, method).method == method
    np.testing.assert_allclose(run.accumulated.values, expected.accumulated.values, atol=1e-8)


# -- colours --------------------------------------------------------------------------------------


@every_kind
def test_coloured_walls_are_separate_grey_runs(blocking):
    albedo, flux = (0.0, 0.4, 0.9), (1.0, 2.0, 0.5)
    coloured = simulate(
        scene_of(LOOSE, albedo, {**LIGHT, "flux": flux}), "dom26", blocking=blocking
    )
    coloured.run(12)
    for colour, (share, emitted) in enumerate(zip(albedo, flux)):
        light = {**LIGHT, "flux": emitted}
        grey = simulate(scene_of(LOOSE, share, light), "dom26", blocking=blocking)
        grey.run(12)
        assert_same_colour(coloured, colour, grey, within=ROUNDING)


# -- where it goes --------------------------------------------------------------------------------


def reflection_of(polygons, albedo=0.5, bands=3, shape=SHAPE):
    scene = scene_of(tuple(polygons), albedo)
    run = simulate(scene, "dom26", bands=bands)
    return run, run._occlusion.reflections[0]


def test_all_that_is_stopped_is_shared_out():
    """Whatever the walls' places: albedo times 1 − τ comes back, in every cell and direction."""
    run, reflection = reflection_of(LOOSE)
    stopped = 1 - run._occlusion.transmittance[(slice(None), *reflection.cells.T)]
    np.testing.assert_allclose(reflection.lobes[..., 0], 0.5 * stopped.T, atol=ROUNDING)


def test_walls_share_by_the_area_they_cover():
    """Two parts of one beam, 0.3 of it white and 0.15 black."""
    grid, offsets, basis = Grid((4, 3, 3)), np.array([(1, 0, 0)]), basis_for(3, 2)
    white = [(2, 1, 1), (2, 1.3, 1), (2, 1.3, 2), (2, 1, 2)]
    black = [(2, 1.7, 1.5), (2, 2, 1.5), (2, 2, 2), (2, 1.7, 2)]
    walls = [*Walls3d((white,), 1.0).walls(), *Walls3d((black,), 0.0).walls()]
    tau = exact_transmittance(grid, walls, offsets)
    (reflection,) = exact_reflection(grid, walls, offsets, basis, tau)
    np.testing.assert_array_equal(reflection.cells, [[1, 1, 1]])
    assert tau[0, 1, 1, 1] == pytest.approx(0.55, abs=ROUNDING)
    back = basis.lambertian([-1.0, 0.0, 0.0], basis.flux_weight)
    np.testing.assert_allclose(reflection.lobes[0, 0], 0.3 * back, atol=ROUNDING)


def test_the_lobe_is_that_of_the_wall_on_the_side_of_the_light():
    """Both sides of a slanted wall send light back along their own normals."""
    wall = [(0, 0, 0), (11, 11, 0), (11, 11, 9), (0, 0, 9)]
    run, reflection = reflection_of([wall])
    normal = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2)
    for lobes in reflection.lobes:
        for offset, lobe in zip(run.stencil.offsets, lobes):
            if lobe[0]:
                facing = -np.sign(normal @ offset) * normal
                expected = run.basis.clamped_cosine(facing)
                np.testing.assert_allclose(lobe / lobe[0], expected / expected[0], atol=1e-12)
                assert lobe[0] <= 0.5 + ROUNDING


def test_cutting_a_wall_into_triangles_changes_nothing():
    whole, pieces = reflection_of(LOOSE[:2]), reflection_of(triangles_of(LOOSE[:2]))
    np.testing.assert_array_equal(whole[1].cells, pieces[1].cells)
    np.testing.assert_allclose(whole[1].lobes, pieces[1].lobes, atol=1e-11)


@every_kind
@pytest.mark.parametrize("scheme", ["lpv", "dom26"])
def test_turned_and_mirrored_scenes_have_turned_and_mirrored_light(blocking, scheme):
    """Flux of every cell after six steps, under the 48 symmetries of a cube."""
    light = {**LIGHT, "cell": [5, 4, 4], "direction": None}
    scene = scene_of(LOOSE, 0.8, {k: v for k, v in light.items() if v})
    plain = simulate(scene, scheme, blocking=blocking)
    plain.run(6)
    cells = np.argwhere(np.ones(SHAPE))
    for matrix in CUBE[1::11]:
        shape = np.abs(matrix @ SHAPE)
        centres = (cells + 0.5 - np.array(SHAPE) / 2) @ matrix.T + shape / 2
        there = np.floor(centres).astype(int)
        walls = tuple(
            (np.array(w, float) - np.array(SHAPE) / 2) @ matrix.T + shape / 2 for w in LOOSE
        )
        cell = there[np.ravel_multi_index(light["cell"], SHAPE)].tolist()
        turned = simulate(
            space_scene(
                Walls3d(walls, 0.8),
                shape=tuple(shape.tolist()),
                light={"kind": "cell", "cell": cell, "flux": FLUX},
            ),
            scheme,
            blocking=blocking,
        )
        turned.run(6)
        found = turned.accumulated.values[(0, *there.T)]
        np.testing.assert_allclose(found, plain.accumulated.values[0].ravel(), atol=1e-12)
