"""Radiance cascades: merging adds nothing and loses nothing but what each variant is known to."""

import numpy as np
import pytest
from alike import SAME, mirrored, mirrored_scene, turned, turned_scene
from analytic_scenes import LIGHTS, WALLS, make_scene
from tabulated import clutter, error, exact, one_light
from test_analytic_known import BOX
from test_analytic_montecarlo import nearest_hit

from flatland import load_scene
from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics
from propagators.analytic import Analytic
from propagators.cascades import RadianceCascades
from propagators.cascades.levels import Plan
from propagators.cascades.propagator import FIXES

FINE = {"spacing": 0.5}
FINEST = {"spacing": 0.5, "bins": 128, "interval": 4.0}
every_fix = pytest.mark.parametrize("fix", FIXES)
fixed = pytest.mark.parametrize("fix", ["bilinear", "cheap"])


def cascades(**options):
    return RadianceCascades(**options)


def gathered(cell, bins, nodes, bands):
    """Outflow of a cell of the scene with LIGHTS and WALLS, by rays of its own."""
    angles = (np.arange(bins) + 0.5) * (2 * np.pi / bins)
    travel = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    basis, half = CircularHarmonics(bands), np.pi / bins
    node, weight = np.polynomial.legendre.leggauss(nodes)
    total = np.zeros(basis.size)
    for axis, ahead in ((0, 0), (0, 1), (1, 0), (1, 1)):
        normal = np.zeros(2)
        normal[axis] = 2 * ahead - 1
        turn = np.arctan2(normal[1], normal[0])
        table = basis.cosine_arc_integral(angles - half, angles + half, turn)
        for place, length in zip(0.5 + 0.5 * node, 0.5 * weight):
            point = np.array(cell, float)
            point[axis] += ahead - 1e-6 * normal[axis]
            point[1 - axis] += place
            for ray in np.flatnonzero(travel @ normal > 0):
                total += length * radiance(point, -travel[ray]) * table[ray]
    return total


def radiance(point, way):
    """What is seen from a point along a unit vector."""
    surfaces = [*[light[:2] for light in LIGHTS], *WALLS]
    reaches = [nearest_hit(point[None], way[None], [ends])[0] for ends in surfaces]
    first = int(np.argmin(reaches))
    if first >= len(LIGHTS) or not np.isfinite(reaches[first]):
        return 0.0
    start, stop, flux = LIGHTS[first]
    extent = np.subtract(stop, start)
    in_front = extent[1] * way[0] - extent[0] * way[1] > 0
    return flux / (2 * np.hypot(*extent)) if in_front else 0.0


def test_one_open_level_is_a_direct_gather():
    """In cells whose faces nothing cuts."""
    values = cascades(interval=1000.0, bins=16).solve(make_scene(), 3).values
    for cell in ((0, 3), (4, 5), (7, 7), (3, 6)):
        np.testing.assert_allclose(
            values[:, cell[0], cell[1]], gathered(cell, 16, 2, 3), rtol=0, atol=1e-12
        )


@every_fix
def test_one_open_level_has_nothing_to_merge(fix):
    one = {"interval": 1000.0, "bins": 32}
    expected = cascades(**one).solve(make_scene(), 3).values
    np.testing.assert_array_equal(cascades(fix=fix, **one).solve(make_scene(), 3).values, expected)


@pytest.mark.parametrize(
    ("scene", "options", "tabulated"),
    [
        (one_light, {"fix": "vanilla"}, (0.115, 0.113, 0.121)),
        (one_light, {"fix": "cheap"}, (0.029, 0.044, 0.087)),
        (one_light, {"fix": "bilinear"}, (0.0175, 0.037, 0.082)),
        (one_light, FINE, (0.007, 0.012, 0.030)),
        (one_light, FINEST, (0.006, 0.008, 0.013)),
        (clutter, {"fix": "vanilla"}, (0.103, 0.121, 0.147)),
        (clutter, {"fix": "cheap"}, (0.040, 0.059, 0.094)),
        (clutter, {"fix": "bilinear"}, (0.031, 0.049, 0.085)),
    ],
)
def test_errors_are_those_tabulated(scene, options, tabulated):
    made = scene()
    values = cascades(**options).solve(made, 8).values
    reference = exact(made, 8)
    for bands, expected in zip((2, 4, 8), tabulated):
        size = 2 * bands - 1
        # One digit stands for the finest.
        found = error(values[:size], reference[:size])
        assert found == pytest.approx(expected, rel=0.06, abs=5e-4), bands


@fixed
def test_a_box_of_uniform_radiance_is_exact_with_a_fix(fix):
    scene = make_scene(lights=BOX, walls=())
    values = cascades(fix=fix).solve(scene, 8).values
    np.testing.assert_allclose(values, exact(scene, 8), rtol=0, atol=1e-12)


def test_without_a_fix_probes_outside_the_walls_are_black():
    scene = make_scene(lights=BOX, walls=())
    missing = exact(scene, 8) - cascades(fix="vanilla").solve(scene, 8).values
    assert np.abs(missing).max() == pytest.approx(0.63, abs=0.01)


@pytest.mark.parametrize(("fix", "least", "most"), [("vanilla", 0.01, 0.1), ("bilinear", 0, 1e-3)])
def test_light_in_dark_cells(fix, least, most):
    for name in ("shelf", "corridor"):
        scene = load_scene(name)
        reference = exact(scene, 1)[0]
        values = cascades(fix=fix).solve(scene, 1).values[0]
        dark = reference <= 1e-12 * reference.max()
        assert least < values[dark].sum() / values.sum() < most


@pytest.mark.parametrize("name", SAME)
def test_other_descriptions_of_a_scene_have_its_answer(name):
    values = cascades(bins=32).solve(make_scene(), 4).values
    found = cascades(bins=32).solve(SAME[name](), 4).values
    np.testing.assert_allclose(found, values, rtol=0, atol=1e-10)


@every_fix
def test_mirrored_and_turned_scenes_have_mirrored_and_turned_answers(fix):
    values = cascades(fix=fix, bins=32).solve(make_scene(), 4).values
    for scene, expected in (
        (mirrored_scene(), mirrored(values)),
        (turned_scene(), turned(values)),
    ):
        found = cascades(fix=fix, bins=32).solve(scene, 4).values
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_intervals_tile_the_distance_and_bins_split():
    levels = Plan(64, 4, 1.0, 2.0).levels((32, 32))
    assert [level.start for level in levels] == [0, 2, 10, 42]
    assert [level.stop for level in levels[:-1]] == [2, 10, 42]
    assert levels[-1].stop > 45.3
    assert [len(level.directions) for level in levels] == [64, 64, 256, 1024]
    assert [level.spacing for level in levels[1:]] == [1, 2, 4]
    # A ring outside the grid, so that 4 probes lie around every point in it.
    assert [level.count_x for level in levels[1:]] == [34, 18, 10]


@pytest.mark.parametrize(("fix", "most"), [("vanilla", 0.12), ("bilinear", 0.05)])
def test_bounces_come_near_the_reference(fix, most):
    scene = make_scene(albedo=0.7)
    answer = cascades(fix=fix).answer(scene, 2)
    assert error(answer.field.values, exact(scene, 2)) < most
    assert error(exact(make_scene(), 2), exact(scene, 2)) > 2 * most
    books = Analytic().energy(scene)
    assert answer.ledger.left == pytest.approx(books.left, rel=most)
    assert answer.ledger.absorbed == pytest.approx(books.absorbed, rel=2 * most)
    assert abs(answer.ledger.closure) < 1e-12
    # Nothing is conserved, and the books say how much is not.
    assert 1e-3 < abs(answer.ledger.created) < 0.1 * answer.ledger.emitted


def test_coloured_rooms_are_solved_colour_by_colour():
    scene = make_scene(
        lights=[((1.2, 1.1), (3.9, 1.7), [3.0, 1.0])], albedo=[0.5, 0.9], walls=WALLS[:2]
    )
    values = cascades(bins=16).solve(scene, 2).values
    for k, albedo in enumerate((0.5, 0.9)):
        grey = make_scene(
            lights=[((1.2, 1.1), (3.9, 1.7), (3.0, 1.0)[k])], albedo=albedo, walls=WALLS[:2]
        )
        one = cascades(bins=16).solve(grey, 2).values
        np.testing.assert_allclose(values[k], one, rtol=0, atol=1e-5)


@pytest.mark.parametrize("count", [1, 2])
def test_one_thread_or_two(count, monkeypatch):
    expected = cascades(bins=16).solve(make_scene(), 2).values
    monkeypatch.setenv("FLATLAND_THREADS", str(count))
    found = cascades(bins=16).solve(make_scene(), 2).values
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    ("bins", "bands", "rule"),
    [(18, 2, "must be a multiple of 4"), (16, 5, "must be at least 20, 4 for each band")],
)
def test_bad_bins_are_refused(bins, bands, rule):
    with pytest.raises(InputError, match=f"bins = {bins}: {rule}"):
        cascades(bins=bins).solve(make_scene(), bands)
