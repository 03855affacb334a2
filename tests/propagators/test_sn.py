"""Grid sweeps: how a cell is crossed, what is conserved, and the false scattering that is left."""

import numpy as np
import pytest
from alike import mirrored, mirrored_scene, turned, turned_scene
from analytic_scenes import make_scene, random_scene, room
from scipy.special import comb
from tabulated import clutter, error, exact, one_light
from test_analytic_known import BOX

from flatland import load_scene
from flatland.errors import ConvergenceError
from propagators.analytic import Analytic
from propagators.beam import Beam
from propagators.sn import GridSweeps
from propagators.sn.sweeping import RULES
from propagators.sn.volumes import DIAMOND, STEP, STEP_CHARACTERISTICS, cross_empty_cell

ROUNDING = 1e-12
CONSERVING = ("step", "diamond", "step-characteristics")
every_rule = pytest.mark.parametrize("rule", RULES)
every_conserving_rule = pytest.mark.parametrize("rule", CONSERVING)


def sweeps(rule="step-characteristics", ordinates=64, **options):
    return GridSweeps(rule=rule, ordinates=ordinates, **options)


def just_inside():
    """Scene 1 with its light in the cells in front of its grid line."""
    return make_scene((32, 32), [((6, 1 + 1e-7), (11, 1 + 1e-7), 5)], ())


def impulse(rule, c, s, steps):
    """Mean radiances on the E faces of column k, row j, of light 1 into the W face of row 0."""
    west, south = np.eye(1, steps)[0], np.zeros(steps + 1)
    history = []
    for _ in range(steps):
        inflow = 0.0
        east = np.empty(steps)
        for j in range(steps):
            east[j], inflow = cross_empty_cell(rule, c, s, west[j], inflow)
        west = east
        history.append(east)
    assert not np.any(south)
    return history


def test_step_spreads_an_impulse_as_a_negative_binomial():
    """At 45 degrees half of what enters a cell leaves through each face: a face is reached by k + j
    turns, the last of them to the right."""
    half = np.sqrt(0.5)
    for k, east in enumerate(impulse(STEP, half, half, 8)):
        j = np.arange(8)
        np.testing.assert_allclose(east, comb(k + j, j) / 2.0 ** (k + j + 1), rtol=1e-14)


def test_diamond_moves_an_impulse_along_the_diagonal():
    half = np.sqrt(0.5)
    east, north = cross_empty_cell(DIAMOND, half, half, 1.0, 0.0)
    assert (east, north) == pytest.approx((0.0, 1.0), abs=1e-15)
    assert cross_empty_cell(DIAMOND, half, half, 0.0, 1.0) == pytest.approx((1.0, 0.0), abs=1e-15)


def test_step_characteristics_at_the_knights_move():
    c, s = 2 / np.sqrt(5), 1 / np.sqrt(5)
    for west, south in ((1.0, 0.0), (0.0, 1.0), (0.3, 0.8)):
        east, north = cross_empty_cell(STEP_CHARACTERISTICS, c, s, west, south)
        assert north == west
        assert east == pytest.approx(0.5 * (west + south), rel=1e-15)
        # And mirrored in the diagonal.
        found = cross_empty_cell(STEP_CHARACTERISTICS, s, c, south, west)
        assert found == pytest.approx((north, east))


@pytest.mark.parametrize("rule", [STEP, DIAMOND, STEP_CHARACTERISTICS])
def test_a_cell_keeps_flux_and_sign(rule, rng):
    for _ in range(200):
        angle = rng.uniform(0.01, np.pi / 2 - 0.01)
        c, s = np.cos(angle), np.sin(angle)
        west, south = rng.uniform(0, 1, 2) * rng.integers(0, 2, 2)
        east, north = cross_empty_cell(rule, c, s, west, south)
        assert min(east, north) >= 0
        assert c * east + s * north == pytest.approx(c * west + s * south, abs=1e-14)
        same = cross_empty_cell(rule, c, s, 0.7, 0.7)
        assert same == pytest.approx((0.7, 0.7), rel=1e-12)


@every_conserving_rule
def test_a_box_of_uniform_radiance_stays_uniform(rule):
    values = sweeps(rule).solve(make_scene(lights=BOX, walls=()), 6).values
    np.testing.assert_allclose(values[0], 8 / np.sqrt(2 * np.pi), rtol=1e-13)
    np.testing.assert_allclose(values, values[:, 3:4, 3:4] + 0 * values, rtol=0, atol=1e-13)


@pytest.mark.parametrize("seed", range(10))
def test_one_cell_is_crossed_as_by_beams(seed):
    """Light that is uniform on the faces of one cell, and walls in it: nothing is approximate."""
    rng = np.random.default_rng(seed)
    walls = [tuple(map(tuple, rng.uniform(0, 1, (2, 2)))) for _ in range(4)]
    border = [((0, 0), (1, 0), 1.0), ((0, 1), (0, 0), 3.0)]
    scene = make_scene((1, 1), border, walls)
    expected = Beam(ordinates=32).answer(scene, 3)
    for rule in CONSERVING:
        found = sweeps(rule, 32).answer(scene, 3)
        if rule == "step-characteristics":
            np.testing.assert_allclose(
                found.field.values, expected.field.values, rtol=0, atol=ROUNDING
            )
        assert found.ledger.absorbed < expected.ledger.absorbed + ROUNDING


@pytest.mark.parametrize(
    ("scene", "rule", "options", "tabulated"),
    [
        (just_inside, "step", {}, (0.111, 0.155, 0.267)),
        (one_light, "diamond", {}, (0.043, 0.050, 0.065)),
        (one_light, "step-characteristics", {}, (0.064, 0.078, 0.118)),
        (one_light, "nodal", {"lights_block": True}, (0.364, 0.402, 0.441)),
        (clutter, "step", {}, (0.109, 0.149, 0.223)),
        (clutter, "diamond", {}, (0.069, 0.090, 0.118)),
        (clutter, "step-characteristics", {}, (0.078, 0.103, 0.143)),
        (clutter, "step-characteristics", {"lights_block": True}, (0.151, 0.179, 0.218)),
        (clutter, "nodal", {"lights_block": True}, (0.173, 0.215, 0.270)),
    ],
)
def test_errors_are_near_those_tabulated(scene, rule, options, tabulated):
    made = scene()
    for bands, expected in zip((2, 4, 8), tabulated):
        found = error(sweeps(rule, **options).solve(made, bands).values, exact(made, bands))
        assert found == pytest.approx(expected, rel=0.04), bands


def test_light_of_a_grid_line_is_mixed_over_the_faces_of_the_cell_in_front():
    """The table's code had it 1e-7 inside that cell, which is then crossed exactly."""
    found = error(sweeps("step").solve(one_light(), 2).values, exact(one_light(), 2))
    assert found == pytest.approx(0.1245, rel=0.02)


def test_more_ordinates_do_not_help_and_more_cells_do_slowly():
    errors = {
        (scale, count): error(
            sweeps(ordinates=count).solve(one_light(scale), 2).values, exact(one_light(scale), 2)
        )
        for scale in (1, 2)
        for count in (128, 512)
    }
    for scale in (1, 2):
        assert errors[scale, 512] > 0.95 * errors[scale, 128], errors
    assert 0.4 < errors[2, 512] / errors[1, 512] < 0.8, errors


@every_rule
@pytest.mark.parametrize("albedo", [0.0, 0.7])
def test_books_close(rule, albedo):
    for scene in (make_scene(albedo=albedo), random_scene(3, step=0.5, albedo=albedo)):
        ledger = sweeps(rule).answer(scene, 2).ledger
        assert abs(ledger.closure) < ROUNDING
        assert abs(ledger.inside) < 1e-8
        if rule != "nodal":
            assert ledger.created == 0
            assert ledger.emitted == pytest.approx(Analytic().energy(scene).emitted, rel=1e-12)


def test_lights_that_block_take_their_own_light_back():
    """Light above the middle of a row of cells: mixed over a face, it falls back onto the light."""
    scene = make_scene((24, 24), [((3, 2.5), (9, 2.5), 3.0)], ())
    transparent = sweeps(ordinates=256).answer(scene, 1).ledger
    assert transparent.left == pytest.approx(3, rel=1e-12)
    blocking = sweeps(ordinates=256, lights_block=True).answer(scene, 1).ledger
    assert blocking.left == pytest.approx(2.5433, abs=2e-3)


def test_nodes_lose_light():
    ledger = sweeps("nodal").answer(one_light(), 1).ledger
    assert ledger.left == pytest.approx(0.70 * 5, rel=0.01)
    assert ledger.created == pytest.approx(ledger.left - 5)


@every_rule
def test_mirrored_and_turned_scenes_have_mirrored_and_turned_answers(rule):
    values = sweeps(rule).solve(make_scene(), 4).values
    for scene, expected in (
        (mirrored_scene(), mirrored(values)),
        (turned_scene(), turned(values)),
    ):
        found = sweeps(rule).solve(scene, 4).values
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("rule", ["step", "step-characteristics", "nodal"])
def test_lights_superpose(rule):
    lights = [((1.2, 1.1), (3.9, 1.7), 3.0), ((6.6, 6.8), (6.1, 4.3), 2.0)]
    both = sweeps(rule).solve(make_scene(lights=lights, albedo=0.5), 3).values
    # A wall that was a light is black; apart from that, each shines for itself.
    parts = [
        make_scene(lights=[(a, b, f if k == other else 0.0) for k, (a, b, f) in enumerate(lights)],
                   albedo=0.5)
        for other in (0, 1)
    ]  # fmt: skip
    total = sum(sweeps(rule).solve(part, 3).values for part in parts)
    np.testing.assert_allclose(both, total, rtol=0, atol=1e-8)


@every_conserving_rule
def test_bounces_come_near_the_reference(rule):
    scene = load_scene("cornell-2d")
    assert error(sweeps(rule).solve(scene, 2).values, exact(scene, 2)) < 0.15
    without = error(sweeps(rule, bounces=False).solve(scene, 2).values, exact(scene, 2))
    assert without > 0.3


@pytest.mark.parametrize("rule", ["step-characteristics", "diamond"])
def test_light_in_a_closed_white_room_never_ends(rule):
    cell = {"kind": "cell", "cell": [2, 3], "flux": 1.0}
    scene = make_scene(lights=(), walls=room(), albedo=1.0, points=[cell])
    with pytest.raises(ConvergenceError, match="albedo must be below 1"):
        sweeps(rule, 16).solve(scene, 1)


@every_conserving_rule
def test_light_leaks_past_the_end_of_a_wall(rule):
    """Mixing over faces puts light where none goes, if little of it."""
    scene = load_scene("shelf")
    reference = exact(scene, 1)[0]
    values = sweeps(rule).solve(scene, 1).values[0]
    dark = reference <= 1e-12 * reference.max()
    share = values[dark].sum() / values.sum()
    assert 0 < share < 0.05


def test_one_thread_or_two(monkeypatch):
    scene = make_scene((30, 40), albedo=0.3)
    values = {}
    for count in (1, 2):
        monkeypatch.setenv("FLATLAND_THREADS", str(count))
        values[count] = sweeps(ordinates=64).solve(scene, 3).values
    np.testing.assert_allclose(values[1], values[2], rtol=0, atol=1e-9)
