"""Light that walls send back: nothing gained, nothing lost, every colour by itself."""

import numpy as np
import pytest
from books import assert_same_books, assert_same_colour
from scenes import assert_same_state

import propagators
from flatland.scene import Scene
from flatland.simulation import Simulation

SHAPE = (12, 11)
FLUX = 2.0
ROUNDING = 1e-12
BOX = [[2.0, 2.0], [9.0, 2.0], [9.0, 8.0], [2.0, 8.0]]
TILTED = [[6.0, 1.3], [10.7, 5.2], [6.1, 9.7], [1.2, 5.1]]
#: Walls in an open grid, crossing one another and the border.
LOOSE = [(1.0, 2.0, 6.3, 2.4), (6.1, 1.0, 9.2, 7.7), (-1.0, 8.2, 5.0, 9.5), (8.0, 3.0, 13.0, 3.0)]

every_kind = pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
schemes = pytest.mark.parametrize("scheme", ["lpv", "dom4", "dom8"])


def scene_with(occluders, flux=FLUX, light=None):
    light = light or {"kind": "cell", "cell": [5, 5], "direction": [1.0, 0.3], "flux": flux}
    return Scene.from_dict({"grid": {"shape": SHAPE}, "light": [light], "occluder": occluders})


def box(albedo, vertices=BOX, **arguments):
    return scene_with([{"kind": "polygon", "vertices": vertices, "albedo": albedo}], **arguments)


def loose(albedo, **arguments):
    walls = [
        {"kind": "segment", "start": wall[:2], "end": wall[2:], "albedo": albedo} for wall in LOOSE
    ]
    return scene_with(walls, **arguments)


def simulate(scene, scheme="lpv", **arguments):
    return Simulation(scene, propagators.create(scheme), **arguments)


# -- books ----------------------------------------------------------------------------------------


@every_kind
@schemes
@pytest.mark.parametrize("bands", [1, 3])
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_books_close_and_flux_never_grows(blocking, scheme, bands, precision):
    """With 3 bands a ringing intensity sends some negative flux to a wall, black or not: the light
    then exceeds that of the step before, but never what was emitted."""
    run = simulate(loose(0.8), scheme, bands=bands, blocking=blocking, precision=precision)
    rounding = ROUNDING if precision == "float64" else 1e-5
    run.inject()
    before = FLUX
    for _ in range(50):
        run.step()
        books = run.ledger
        assert abs(books.closure) < rounding
        assert books.inside == pytest.approx(
            float(run.target.values[0].sum()) * run.basis.flux_weight, abs=rounding
        )
        assert books.inside <= before + rounding
        before = books.inside if bands == 1 else FLUX
    assert run.ledger.reflected > 0.1


@every_kind
def test_absorbed_is_what_was_stopped_and_not_sent_back(blocking):
    """The same entries from plain arrays, step by step."""
    run = simulate(loose(0.8), "dom8", bands=3, blocking=blocking)
    tau, rows = run._occlusion.transmittance, run.stencil.transfer[:, 0, :]
    stopped = absorbed = 0.0
    run.inject()
    for step in range(20):
        flux = np.tensordot(rows, run.target.values, 1) * run.basis.flux_weight
        if step or not run._occlusion.free_first_step:
            stopped += float(((1 - tau) * flux).sum())
        run.step()
        absorbed = float(run.ledger.absorbed)
        assert stopped - run.ledger.reflected == pytest.approx(absorbed, abs=ROUNDING)
    assert absorbed == pytest.approx(0.2 * stopped, rel=1e-9)


@schemes
@pytest.mark.parametrize("bands", [1, 2, 4])
@pytest.mark.parametrize("vertices", [BOX, TILTED], ids=["straight", "tilted"])
def test_a_white_box_keeps_all_its_light(scheme, bands, vertices):
    run = simulate(box(1.0, vertices), scheme, bands=bands)
    run.run(200)
    assert run.ledger.inside == pytest.approx(FLUX, rel=ROUNDING)
    assert run.ledger.left == 0
    assert run.ledger.absorbed == pytest.approx(0.0, abs=ROUNDING)


@schemes
@pytest.mark.parametrize("albedo", [0.3, 0.9])
def test_furnace(scheme, albedo):
    """Every wall gets Φ, then ρΦ, ρ²Φ, …: Φ/(1 − ρ) in all, and keeps Φ."""
    run = simulate(box(albedo, TILTED), scheme, bands=2)
    run.solve(1e-11)
    assert run.ledger.absorbed == pytest.approx(FLUX, rel=1e-8)
    received = run.ledger.absorbed + run.ledger.reflected
    assert received == pytest.approx(FLUX / (1 - albedo), rel=1e-8)


# -- the converged field --------------------------------------------------------------------------


@every_kind
@schemes
def test_solving_equals_stepping(blocking, scheme):
    stepped, solved = (simulate(loose(0.7), scheme, bands=3, blocking=blocking) for _ in range(2))
    stepped.run(2500)
    report = solved.solve(1e-11)
    np.testing.assert_allclose(
        solved.accumulated.values, stepped.accumulated.values, atol=1e-9, err_msg=report.method
    )
    entries = ("emitted", "left", "absorbed", "reflected")
    assert_same_books(solved.ledger, stepped.ledger, entries, within=1e-8)


@every_kind
@pytest.mark.parametrize("method", ["multigrid", "krylov", "factorization", "stepping"])
def test_all_methods_know_of_bounces(blocking, method):
    scene = loose(0.7)
    expected = simulate(scene, "dom8", blocking=blocking)
    expected.run(1500)
    run = simulate(scene, "dom8", blocking=blocking)
    run.solve(1e-10, method)
    np.testing.assert_allclose(run.accumulated.values, expected.accumulated.values, atol=1e-8)


def test_factors_of_black_walls_are_not_used_for_white_ones():
    black, white = simulate(loose(0.0)), simulate(loose(0.9))
    black.solve(1e-10, "factorization")
    white.solve(1e-10, "factorization")
    assert white.ledger.absorbed < 0.5 * black.ledger.absorbed


# -- colours --------------------------------------------------------------------------------------


@every_kind
def test_coloured_walls_are_separate_grey_runs(blocking):
    albedo, flux = (0.0, 0.4, 0.9), (1.0, 2.0, 0.5)
    coloured = simulate(loose(albedo, flux=flux), "dom8", blocking=blocking)
    coloured.run(30)
    for colour, (share, emitted) in enumerate(zip(albedo, flux)):
        grey = simulate(loose(share, flux=emitted), "dom8", blocking=blocking)
        grey.run(30)
        assert_same_colour(coloured, colour, grey, within=ROUNDING)


def test_grey_walls_need_one_pattern_for_coloured_light():
    run = simulate(loose((0.5, 0.5, 0.5), flux=(1.0, 2.0, 0.5)))
    assert len(run._states) == 1
    assert len(simulate(loose((0.5, 0.5, 0.4), flux=(1.0, 2.0, 0.5)))._states) == 3


def test_clamped_steps_reflect_what_they_send():
    scheme = propagators.create("lpv", clamp=True)
    run = Simulation(box(1.0), scheme, bands=3)
    run.run(40)
    assert abs(run.ledger.closure) < ROUNDING * run.ledger.inside
    assert run.ledger.absorbed == pytest.approx(0.0, abs=ROUNDING * run.ledger.inside)
    assert run.ledger.inside == pytest.approx(FLUX + run.ledger.created, rel=ROUNDING)


# -- off ------------------------------------------------------------------------------------------


@every_kind
def test_black_walls_and_switched_off_bounces_are_the_same_bit_for_bit(blocking):
    runs = [
        simulate(loose(0.0), "dom8", blocking=blocking),
        simulate(loose(0.8), "dom8", blocking=blocking, bounces=False),
    ]
    for run in runs:
        assert run._occlusion.reflections == ()
        run.run(40)
    assert_same_state(*runs)


# -- where it goes --------------------------------------------------------------------------------


@every_kind
def test_a_beam_at_normal_incidence_comes_back(blocking):
    wall = {"kind": "segment", "start": [9.0, -1.0], "end": [9.0, 12.0], "albedo": 1.0}
    beam = {"kind": "cell", "cell": [8, 5], "direction": [1.0, 0.0], "flux": 1.0}
    options = {"bands": 4, "blocking": blocking, "strength": 2.0}
    # A step there, one against the wall and the one in which it is sent back.
    run = simulate(scene_with([wall], light=beam), "dom8", **options)
    run.run(1 if blocking == "exact" else 2)
    newest = run.target
    if blocking == "exact":
        towards = newest.values[1, 8, 5]
        assert towards < 0, "the light of the cell beside the wall turns back"
        assert run.ledger.reflected > 0.9
        np.testing.assert_array_equal(newest.values[:, 9:], 0.0)
    run.run(8)
    sent = run.accumulated.values
    across = np.arange(-3, 4)
    mirrored = sent[0, :, 5 + across]
    np.testing.assert_allclose(mirrored, mirrored[::-1], atol=1e-12)
    net = sent[1, 2:8, 5]
    assert np.all(net < 0), f"net flux {net} in front of the wall points away from it"


def test_the_lobe_is_that_of_the_wall_on_the_side_of_the_light():
    """Both sides of a tilted wall send light back along their own normals."""
    wall = {"kind": "segment", "start": [0.0, 0.0], "end": [11.0, 11.0], "albedo": 0.5}
    run = simulate(scene_with([wall]), "dom4", bands=3)
    reflection = run._occlusion.reflections[0]
    normal = np.array([-1.0, 1.0]) / np.sqrt(2)
    for cell, lobes in zip(reflection.cells, reflection.lobes):
        for offset, lobe in zip(run.stencil.offsets, lobes):
            if lobe[0]:
                facing = -np.sign(normal @ offset) * normal
                expected = run.basis.clamped_cosine(facing)
                np.testing.assert_allclose(lobe / lobe[0], expected / expected[0], atol=1e-12)
                assert lobe[0] <= 0.5 + ROUNDING, cell


def test_lamps_leave_their_first_bounce_to_the_walls():
    lamp = {"kind": "point", "position": [5.2, 5.3], "flux": FLUX}
    run = simulate(box(0.5, light=lamp))
    run.run(3)
    assert run.ledger.emitted == pytest.approx(FLUX, rel=1e-12)
    without = simulate(box(0.5, light=lamp), bounces=False)
    without.run(3)
    assert without.ledger.emitted > 1.4 * FLUX
