"""Analytic reference in 3D: what must not change the answer, or change it in a known way."""

from dataclasses import replace

import numpy as np
import pytest
from sphere import cube_symmetries, representation
from volumes import LIGHTS, box, cornell, moved, point, rectangle, volume

from flatland.harmonics import SphericalHarmonics
from propagators.analytic import Analytic
from propagators.watching import watched

WALL = np.array([(2.0, 2.0, 2.2), (5.1, 2.7, 3.4), (2.6, 4.9, 1.6)])
BEAM = ((1.0, -2.0, -1.5), 0.3)
#: Direct light is this exact here; what does not depend on where panels are cut is exact.
TOLERANCE = 1e-3
ROUNDING = 1e-12


def answer(scene, bands=3, **options):
    return Analytic(**{"tolerance": TOLERANCE, **options}).solve(scene, bands).values


def off(first, second):
    return np.linalg.norm(first - second) / np.linalg.norm(second)


def test_lights_add_up():
    lamp = point((4.4, 4.1, 4.7), 0.5, (0, -1, -1))
    parts = [volume((6, 6, 6), [light], [WALL, *(v for v, _ in LIGHTS)]) for light in LIGHTS]
    parts += [volume((6, 6, 6), walls=[WALL, *(v for v, _ in LIGHTS)], points=[lamp])]
    parts += [volume((6, 6, 6), walls=[WALL, *(v for v, _ in LIGHTS)], beams=[BEAM])]
    whole = volume((6, 6, 6), LIGHTS, [WALL], points=[lamp], beams=[BEAM])
    assert off(sum(map(answer, parts)), answer(whole)) < 2 * TOLERANCE


@pytest.mark.parametrize("spacing", [0.25, 3.0])
def test_flux_spacing_and_origin_scale_the_field(spacing):
    near = volume((6, 6, 6), LIGHTS, [WALL])
    far = volume((6, 6, 6), LIGHTS, [WALL], spacing=spacing, origin=(3.0, -1.0, 7.0))
    # The same watts through the same faces, whatever their size. Where errors are compared with
    # the tolerance, rounding decides which panels are cut.
    assert off(answer(far), answer(near)) < TOLERANCE
    # Irradiance is per area.
    beams = [volume((3, 3, 3), beams=[BEAM], spacing=h) for h in (1.0, spacing)]
    assert off(answer(beams[1]), spacing**2 * answer(beams[0])) < ROUNDING


def test_colours_are_answered_apart():
    (first, _), (second, _) = LIGHTS
    coloured = volume((6, 6, 6), [(first, [3.0, 0.0]), (second, [2.0, 1.0])], [WALL])
    found = answer(coloured)
    assert found.shape == (2, 9, 6, 6, 6)
    assert off(found[0], answer(volume((6, 6, 6), LIGHTS, [WALL]))) < 2 * TOLERANCE


def test_a_light_in_two_parts_is_one_light():
    first, second = (
        rectangle((1, 1, 1), (2, 0, 0), (0, 1, 0)),
        rectangle((1, 2, 1), (2, 0, 0), (0, 2, 0)),
    )
    whole = rectangle((1, 1, 1), (2, 0, 0), (0, 3, 0))
    parts = volume((6, 6, 6), [(first, 2.0), (second, 4.0)], [WALL])
    assert off(answer(parts), answer(volume((6, 6, 6), [(whole, 6.0)], [WALL]))) < 2 * TOLERANCE


def test_a_wall_in_parts_is_one_wall():
    middle = WALL.mean(axis=0)
    parts = [np.array([a, b, middle]) for a, b in zip(WALL, np.roll(WALL, -1, axis=0))]
    first, second = (volume((6, 6, 6), LIGHTS, walls) for walls in ([WALL], parts))
    assert off(answer(second), answer(first)) < TOLERANCE
    directions = np.eye(3)
    whole, cut = (Analytic().intensity(scene, directions) for scene in (first, second))
    np.testing.assert_allclose(cut, whole, atol=ROUNDING)


def test_the_way_round_a_wall_makes_no_difference():
    scenes = [volume((6, 6, 6), LIGHTS, [wall], albedo=0.5) for wall in (WALL, WALL[::-1])]
    # Lines start elsewhere on the turned wall: the same to the tolerance of bounces.
    assert off(*(answer(scene, tolerance=1e-2) for scene in scenes)) < 2e-2
    assert off(*(answer(scene, bounces=False) for scene in scenes)) < TOLERANCE


def test_walls_behind_the_light_or_outside_the_grid_change_nothing():
    scene = volume((6, 6, 6), [LIGHTS[1]], [WALL])
    behind = [vertices for vertices, _ in box((5.1, 4.7, 0.1), (5.9, 5.8, 0.6))]
    outside = [moved(WALL, z=-8), moved(WALL, x=9)]
    for more in (behind, outside):
        other = volume((6, 6, 6), [LIGHTS[1]], [WALL, *more])
        np.testing.assert_allclose(answer(other), answer(scene), rtol=0, atol=ROUNDING)


SYMMETRIES = list(cube_symmetries())
#: All 48, a few of them every time.
TURNS = [
    number if number in (1, 10, 17, 30, 44) else pytest.param(number, marks=pytest.mark.slow)
    for number in range(48)
]


@pytest.mark.parametrize("number", TURNS)
def test_turned_scenes_have_turned_answers(number):
    turn = SYMMETRIES[number]
    lights = [LIGHTS[0]]
    points, beams = [point((4.5, 1.5, 3.5), 0.5, (1, 2, -1))], [BEAM]
    scene = volume((6, 6, 6), lights, [WALL], points=points, beams=beams)
    other = volume(
        (6, 6, 6),
        [(turned(vertices, turn), flux) for vertices, flux in lights],
        [turned(WALL, turn)],
        points=[turned_lamp(lamp, turn) for lamp in points],
        beams=[(turn @ np.array(way), strength) for way, strength in beams],
    )
    expected = turn_cells(answer(scene), turn)
    turned_bands = representation(SphericalHarmonics(3), turn)
    assert off(answer(other), np.tensordot(turned_bands, expected, 1)) < 2 * TOLERANCE


def turned(vertices, turn):
    """A polygon about the middle of the grid; mirrored ones are walked the other way."""
    result = (np.asarray(vertices) - 3) @ turn.T + 3
    return result if np.linalg.det(turn) > 0 else result[::-1]


def turned_lamp(lamp, turn):
    place = turn @ (lamp.position - 3) + 3
    return replace(lamp, position=place, lobe_direction=turn @ lamp.lobe_direction)


def turn_cells(values, turn):
    """values (..., n, n, n) moved to the cells that a symmetry maps theirs to."""
    cells = np.indices(values.shape[-3:]).reshape(3, -1)
    middle = (values.shape[-1] - 1) / 2
    targets = np.rint(turn @ (cells - middle) + middle).astype(int)
    result = np.empty_like(values)
    result[(..., *targets)] = values[(..., *cells)]
    return result


@pytest.mark.slow
@pytest.mark.parametrize("number", [5, 33])
def test_turned_rooms_have_turned_answers_bounces_included(number):
    turn, tolerance = SYMMETRIES[number], 2e-3
    room = cornell(6, colours=False)
    lights = [(light.vertices, light.spectrum) for light in room.lights]
    walls = [(wall.vertices, wall.albedo) for wall in room.walls]
    other = volume(
        (6, 6, 6),
        [(turned(vertices, turn), flux) for vertices, flux in lights],
        [(turned(vertices, turn), albedo) for vertices, albedo in walls],
    )
    first, second = (answer(scene, tolerance=tolerance) for scene in (room, other))
    turned_bands = representation(SphericalHarmonics(3), turn)
    assert off(second, np.tensordot(turned_bands, turn_cells(first, turn), 1)) < 2 * tolerance


def test_the_tolerance_is_kept():
    scene = volume((6, 6, 6), LIGHTS, [WALL])
    exact = answer(scene, tolerance=1e-4)
    for tolerance in (1e-1, 1e-2, 2e-3):
        assert off(answer(scene, tolerance=tolerance), exact) < tolerance


@pytest.mark.slow
@pytest.mark.parametrize("walls", [[], [WALL]], ids=["free", "shaded"])
def test_small_tolerances_are_kept(walls):
    scene = volume((6, 6, 6), LIGHTS, walls)
    exact = answer(scene, tolerance=2e-6)
    for tolerance in (1e-3, 1e-4, 1e-5):
        assert off(answer(scene, tolerance=tolerance), exact) < tolerance


@pytest.mark.slow
def test_the_tolerance_is_kept_in_a_room():
    room = cornell(8)
    exact = answer(room, tolerance=2e-4, element=0.5)
    for tolerance in (1e-2, 3e-3, 1e-3):
        assert off(answer(room, tolerance=tolerance, element=0.5), exact) < tolerance


def test_progress_rises_to_one():
    room, shares = cornell(4), []
    Analytic(tolerance=1e-2).solve(room, 2, progress=shares.append)
    seen = []
    with watched(seen.append):
        Analytic(tolerance=1e-2).solve(room, 2)
        assert seen == shares
        seen.clear()
        Analytic(tolerance=1e-2).intensity(room, np.eye(3)[np.arange(200) % 3])
    for found in (shares, seen):
        assert found == sorted(found)
        assert found[0] == 0
        assert len(found) > 4
        assert found[-1] == 1


def test_a_watcher_may_stop_an_answer():
    def enough(share):
        raise KeyboardInterrupt

    with watched(enough), pytest.raises(KeyboardInterrupt):
        Analytic().solve(cornell(4), 2)
