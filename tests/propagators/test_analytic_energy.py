"""Analytic reference: no light is lost, whatever touches, crosses or lines up."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene, random_scene

from propagators.analytic import Analytic
from propagators.analytic.balance import arriving_flux
from propagators.analytic.geometry import read_geometry

#: Rounding, in watts of a few emitted.
ROUNDING = 1e-11
LIGHT = ((2, 2), (6, 2), 3.0)
DEGENERATE = {
    "crossing walls, lights that shade each other": (LIGHTS, WALLS),
    "light on a cell border": ([LIGHT], [((3, 3), (5, 4))]),
    "wall through cell corners": ([LIGHT], [((1, 3), (5, 7))]),
    "wall on a cell border": ([LIGHT], [((2, 5), (6, 5))]),
    "collinear, overlapping walls": ([LIGHT], [((2, 4), (5, 5)), ((3.5, 4.5), (6.5, 5.5))]),
    "the same wall twice": ([LIGHT], [((2, 4), (5, 5)), ((5, 5), (2, 4))]),
    "walls that share an end": ([LIGHT], [((2, 4), (4, 5)), ((4, 5), (6, 4)), ((4, 5), (4, 7))]),
    "wall that touches the light": ([LIGHT], [((4, 2), (5, 5))]),
    "wall that stands on the light's end": ([LIGHT], [((6, 2), (6, 5))]),
    "wall through the light": ([LIGHT], [((3.7, 1), (4.4, 5))]),
    "walls that cross on the light": ([LIGHT], [((3, 1), (5, 3)), ((3, 3), (5, 1))]),
    "wall on the light": ([LIGHT], [((2, 2), (6, 2))]),
    "wall on a part of the light and beyond": ([LIGHT], [((5, 2), (7, 2))]),
    "light on the light, front to back": ([LIGHT, ((6, 2), (2, 2), 1.0)], []),
    "wall in line with the light": ([LIGHT], [((0, 2), (2, 2)), ((7, 2), (8, 2))]),
    "light on the grid's border": ([((0, 0), (8, 0), 2.0)], [((2, 2), (6, 2))]),
    "walls on the border and beyond": ([LIGHT], [((0, 1), (0, 9)), ((-5, 6), (20, 7))]),
    "tiny light and tiny wall": ([((4, 4), (4 + 1e-6, 4), 1.0)], [((4, 5), (4 + 1e-6, 5))]),
    "decimals on grid lines": ([((3, 1.1 * 3), (0.1 * 3, 1), 1.0)], [((3, 3), (0.1 * 30, 8))]),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_what_is_emitted_leaves_or_is_absorbed(name):
    lights, walls = DEGENERATE[name]
    with np.errstate(all="raise"):
        ledger = Analytic().energy(make_scene(lights=lights, walls=walls))
    assert abs(ledger.closure) < ROUNDING
    assert ledger.emitted == pytest.approx(sum(flux for *_, flux in lights))
    assert ledger.left > 0


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(25))
def test_random_scenes_balance(seed, step):
    assert abs(Analytic().energy(random_scene(seed, step=step)).closure) < ROUNDING


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_as_much_flux_leaves_an_empty_cell_as_enters_it(seed, step):
    scene = random_scene(seed, step=step)
    geometry = read_geometry(scene)
    faces = geometry.cell_outlines().reshape(-1, 4)
    entering = arriving_flux(geometry, faces[:, [2, 3, 0, 1]])
    leaving = Analytic().solve(scene, 1).scalar_flux().ravel()
    empty = ~touched_cells(scene)
    assert empty.sum() > 10
    difference = entering.reshape(-1, 4).sum(axis=1) - leaving
    np.testing.assert_allclose(difference[empty], 0, rtol=0, atol=ROUNDING)


def touched_cells(scene):
    """Cells that a light or wall comes near to, by dense points."""
    size = scene.grid.shape[0]
    touched = np.zeros((size + 2, size + 2), bool)
    for item in (*scene.sources(), *scene.segments()):
        places = np.linspace(item.start, item.stop, 2000)
        for shift in np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * 0.01:
            cells = np.floor(places + shift).astype(int) + 1
            touched[cells[:, 0], cells[:, 1]] = True
    return touched[1:-1, 1:-1].ravel()


def test_books_by_colour_add_up_like_the_spectrum():
    lights = [(*LIGHTS[0][:2], [3.0, 1.0]), (*LIGHTS[1][:2], [2.0, 0.0])]
    ledger = Analytic().energy(make_scene(lights=lights))
    np.testing.assert_allclose(ledger.emitted, [5, 1])
    np.testing.assert_allclose(ledger.closure, 0, atol=ROUNDING)


def test_a_wall_on_the_border_up_to_rounding_takes_the_light_that_would_leave():
    # 0.1 * 3 lies beyond the border of three cells of 0.1, by rounding.
    wall = ((3, 0), (3, 3))
    scene = make_scene((3, 3), [((0.5, 2), (0.5, 1), 1.0)], [wall], spacing=0.1)
    assert scene.grid.to_cells(scene.segments()[0].start)[0] > 3
    expected = np.hypot(2.5, 2) - np.hypot(2.5, 1)  # crossed strings
    assert Analytic().absorbed(scene)[0] == pytest.approx(expected, abs=1e-14)


def test_absorbed_flux_by_segment_sums_to_the_books():
    dark = Analytic().energy(make_scene()).absorbed
    walls = Analytic().absorbed(make_scene())
    # Lights absorb what they shade from one another.
    assert walls.shape == (4,)
    assert 0 < dark - walls.sum() < 1
