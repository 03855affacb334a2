"""Analytic reference in 3D: no light is lost, whatever touches, crosses or lines up."""

import numpy as np
import pytest
from volumes import LIGHTS, box, moved, point, rectangle, room, unit, volume

from propagators.analytic import Analytic
from propagators.analytic_3d.faces import cut_faces
from propagators.analytic_3d.geometry import read_geometry
from propagators.analytic_3d.lighting import direct_light
from propagators.analytic_3d.panels import Panels

LIGHT = (rectangle((2, 2, 1), (2, 0, 0), (0, 2, 0)), 3.0)
FLAT = rectangle((1.5, 1.7, 3), (2, 0, 0), (0, 1.6, 0))
#: An L, seen from its front: not convex.
CORNER = np.array([(1, 1), (4, 1), (4, 2), (2, 2), (2, 4), (1, 4)], float)
DEGENERATE = {
    "lights that shade each other": (LIGHTS, []),
    "wall on faces of cells": ([LIGHT], [FLAT]),
    "wall through corners of cells": (
        [LIGHT],
        [np.array([(1, 1, 2), (5, 5, 2), (3, 3, 5)], float)],
    ),
    "walls that cross": ([LIGHT], [FLAT, rectangle((2.5, 1, 2), (0, 3, 0), (0, 0, 2))]),
    "overlapping walls in one plane": ([LIGHT], [FLAT, moved(FLAT, 0.7, 0.4)]),
    "the same wall twice": ([LIGHT], [FLAT, FLAT[::-1]]),
    "walls that share an edge": ([LIGHT], [FLAT, rectangle(FLAT[0], (2, 0, 0), (0, 0, 1))]),
    "wall that stands on the light": ([LIGHT], [rectangle((2.5, 3, 1), (1, 0, 0), (0, 0.3, 1))]),
    "wall that stands on the light's edge": ([LIGHT], [rectangle((4, 2, 1), (0, 2, 0), (0, 0, 2))]),
    "wall through the light": ([LIGHT], [rectangle((2.2, 2.5, 0.4), (1.5, 0.3, 0), (0, 0, 1.7))]),
    "wall on the light": ([LIGHT], [LIGHT[0]]),
    "wall in the light's plane": ([LIGHT], [moved(LIGHT[0], 2)]),
    "light on the light, front to back": ([LIGHT, (LIGHT[0][::-1], 1.0)], []),
    "light that is no convex polygon": ([(np.insert(CORNER, 2, 1.0, axis=1)[::-1], 2.0)], [FLAT]),
    "wall that is no convex polygon": ([LIGHT], [np.insert(CORNER, 2, 2.5, axis=1)]),
    "light on the grid's border": ([(rectangle((0, 0, 0), (6, 0, 0), (0, 6, 0)), 2.0)], [FLAT]),
    "walls on the border and beyond": (
        [LIGHT],
        [
            rectangle((0, 1, 1), (0, 9, 0), (0, 0, 9)),
            rectangle((-3, -3, 4), (20, 0, 0), (0, 20, 1)),
        ],
    ),
    "box on a floor": (
        [LIGHT],
        [v for v, _ in [*room((6, 6, 6)), *box((3.2, 1.1, 0), (4.7, 2.6, 2))]],
    ),
    "boxes through one another": (
        [LIGHT],
        [v for v, _ in [*box((1.3, 1.1, 2), (3.7, 2.6, 4)), *box((2.2, 1.6, 1.5), (3, 4, 3.2))]],
    ),
    "light in a box": ([LIGHT], [v for v, _ in box((1, 1, 0.5), (5, 5, 3))]),
}
TOLERANCE = 1e-4


@pytest.mark.parametrize("name", DEGENERATE)
def test_what_is_emitted_leaves_or_is_absorbed(name):
    lights, walls = DEGENERATE[name]
    ledger = Analytic(tolerance=TOLERANCE).energy(volume((6, 6, 6), lights, walls))
    assert ledger.emitted == pytest.approx(sum(flux for _, flux in lights))
    assert abs(ledger.closure) < TOLERANCE * ledger.emitted
    closed = name in ("box on a floor", "light in a box")
    assert (ledger.left < 1e-9) if closed else (ledger.left > 0)


@pytest.mark.parametrize("seed", range(4))
def test_random_scenes_balance(seed):
    rng = np.random.default_rng(seed)
    lights, walls = rng.uniform(0.2, 5.8, (2, 3, 3)), rng.uniform(-1, 7, (5, 3, 3))
    scene = volume((6, 6, 6), [(light, 1.0) for light in lights], list(walls))
    assert abs(Analytic(tolerance=1e-3).energy(scene).closure) < 1e-3 * 2


@pytest.mark.parametrize("step", [0.5, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_random_scenes_on_a_lattice_balance(seed, step):
    """All corners on multiples of a step, so that much lines up."""
    rng = np.random.default_rng(seed)

    def triangle():
        while True:
            corners = np.round(rng.uniform(0, 6, (3, 3)) / step) * step
            if np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) > 0.2:
                return corners

    scene = volume(
        (6, 6, 6), [(triangle(), 1.0), (triangle(), 2.0)], [triangle() for _ in range(5)]
    )
    assert abs(Analytic(tolerance=1e-3).energy(scene).closure) < 1e-3 * 3


@pytest.mark.parametrize(
    "more",
    [
        {"points": [point((2.5, 2.5, 1.5), 2.0), point((4.5, 1.5, 4.5), 1.0, (1, 2, -1))]},
        {"beams": [((1, -2, -0.7), 2.0), ((0, 0, 1), 1.0)]},
    ],
    ids=["points", "beams"],
)
def test_points_and_beams_balance_to_rounding(more):
    walls = [
        FLAT,
        *(v for v, _ in box((3.1, 0, 2), (5.2, 2.3, 3.3))),
        rectangle((0, 0, 0), (6, 0, 0), (0, 3, 0)),
    ]
    ledger = Analytic().energy(volume((6, 6, 6), walls=walls, **more))
    assert abs(ledger.closure) < 1e-12 * ledger.emitted
    assert ledger.absorbed > 0
    assert ledger.left > 0


def test_a_sky_in_the_border_lets_parallel_light_in_and_takes_what_arrives_inside():
    size = (4, 4, 4)
    sky = [(vertices, 1.0) for vertices, _ in room(size)]
    ledger = Analytic(tolerance=TOLERANCE).energy(volume(size, sky, beams=[((1, 1, -2), 1.0)]))
    beam = np.abs(unit((1, 1, -2))).sum() * 16
    assert ledger.emitted == pytest.approx(6 + beam)
    assert ledger.absorbed == pytest.approx(6 + beam, rel=TOLERANCE)
    assert ledger.left == 0


@pytest.mark.parametrize("walls", [[], [moved(FLAT, z=0.5)]], ids=["free", "shaded"])
def test_as_much_flux_leaves_an_empty_cell_as_enters_it(walls):
    beam, lamp = ((1, -2, 3), 1.0), point((4.5, 4.5, 4.5), 1.0)
    scene = volume((6, 6, 6), [LIGHT], walls, beams=[beam], points=[lamp])
    geometry = read_geometry(scene)
    outwards = cut_faces(geometry.grid, geometry.walls)
    inwards = Panels(outwards.corners[:, ::-1], -outwards.normals, outwards.groups)
    leaves, enters = (
        direct_light(geometry, panels, 216, 1, TOLERANCE)[:, 0, 0].reshape(6, 6, 6)
        for panels in (outwards, inwards)
    )
    empty = np.ones((6, 6, 6), bool)
    empty[4, 4, 4] = empty[2:4, 2:4, 0:2] = False
    empty[1:4, 1:4, 3] = not walls
    np.testing.assert_allclose(leaves[empty], enters[empty], rtol=0, atol=TOLERANCE)
    assert abs((leaves - enters)[~empty]).max() > 0.01


def test_absorbed_flux_by_wall_sums_to_the_books():
    scene = volume((6, 6, 6), LIGHTS, [FLAT, moved(FLAT, 0.3, 0.2, 0.8)])
    reference = Analytic(tolerance=TOLERANCE)
    walls, books = reference.absorbed(scene), reference.energy(scene)
    # Lights absorb what they shade from one another.
    assert walls.shape == (2,)
    assert 0 < books.absorbed - walls.sum() < 1


def test_books_by_colour_add_up_like_the_spectrum():
    (first, _), (second, _) = LIGHTS
    scene = volume((6, 6, 6), [(first, [3.0, 1.0]), (second, [2.0, 0.0])], [FLAT])
    ledger = Analytic(tolerance=TOLERANCE).energy(scene)
    np.testing.assert_allclose(ledger.emitted, [5, 1])
    np.testing.assert_allclose(ledger.closure, 0, atol=5 * TOLERANCE)
    assert Analytic().absorbed(scene).shape == (2, 1)


def test_spacing_scales_neither_flux_nor_books():
    near, far = (
        Analytic(tolerance=TOLERANCE).energy(
            volume((6, 6, 6), LIGHTS, [FLAT], spacing=h, origin=(1, -2, h))
        )
        for h in (1.0, 0.25)
    )
    assert near.absorbed == pytest.approx(far.absorbed, abs=1e-9)
    assert near.left == pytest.approx(far.left, abs=1e-9)
