"""Analytic reference in 3D: flows of polygons, and polygons with shadows taken out of them."""

import numpy as np
import pytest
import shapely
from volumes import box, moved, rectangle, unit, volume

from flatland.harmonics import SphericalHarmonics
from flatland.kernels.threads import thread_count
from propagators.analytic import Analytic
from propagators.analytic_3d.faces import cell_faces, cut_faces
from propagators.analytic_3d.geometry import read_geometry
from propagators.analytic_3d.maps import cosine_maps, polygon_map, series_bands, series_map
from propagators.analytic_3d.panels import Panels
from propagators.analytic_3d.plates import clip_to_box, convex_parts, make_plates, polygon_area
from propagators.analytic_3d.shadows import EVERYWHERE
from propagators.analytic_3d.sheets import cut_sheets
from propagators.analytic_3d.windows import seen_flows

ROUNDING = 1e-13


NOTHING = make_plates([])


def quadrilaterals(rng, count):
    """Slanted panels seen from the origin, each about an axis of its own, and no panel beside."""
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    first = np.cross(axis, rng.normal(size=(count, 3)))
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = np.cross(axis, first)
    middle = axis + rng.uniform(-0.6, 0.6, (count, 1)) * first
    half = [a * first + b * second for a, b in ((-0.5, -0.8), (0.7, -0.4), (0.5, 0.9), (-0.6, 0.3))]
    return Panels(middle[:, None] + np.stack(half, axis=1), axis, np.arange(count))


@pytest.mark.parametrize("bands", [1, 2, 3, 6])
def test_flows_are_the_integrals_of_the_basis(bands, rng):
    panels, centre = quadrilaterals(rng, 40), np.array([0.0, 0.0, 0.0, 1.0])
    flows = seen_flows(panels, centre, EVERYWHERE, NOTHING, bands)
    expected = SphericalHarmonics(bands + 1).polygon_integral(panels.corners)
    np.testing.assert_allclose(flows @ polygon_map(bands + 1).T, expected, atol=ROUNDING)
    # A horizon cuts the panels: clamped cosines.
    horizon = np.array([0.0, 0.0, 1.0, 0.0])
    flows = seen_flows(panels, centre, horizon, NOTHING, bands)
    normals = np.tile(horizon[:3], (40, 1))
    expected = SphericalHarmonics(bands).polygon_cosine_integral(panels.corners, normals)
    np.testing.assert_allclose(flows @ cosine_maps(bands)[2].T, expected, atol=ROUNDING)


@pytest.mark.parametrize("length", [1, 4, 9])
def test_series_times_harmonics_are_the_gram_matrix_of_the_polygon(length, rng):
    panels, series = quadrilaterals(rng, 10), rng.normal(size=length)
    centre, bands = np.array([0.0, 0.0, 0.0, 1.0]), series_bands(3, series)
    flows = seen_flows(panels, centre, EVERYWHERE, NOTHING, bands)
    gram = SphericalHarmonics(3).polygon_gram(panels.corners)
    expected = gram[:, :, :length] @ series
    np.testing.assert_allclose(flows @ series_map(3, series).T, expected, atol=ROUNDING)


#: A window that light passes upwards.
WINDOW = np.array([(1, 1, 4), (4, 0.5, 4), (5, 3, 4), (2, 4, 4)], float)


def seen_of(window, centre, walls):
    """Area that parallel light shows of a window, or the solid angle that a point sees."""
    panels = Panels(np.array([window]), np.array([[0.0, 0.0, 1.0]]), np.zeros(1, int))
    flows = seen_flows(panels, np.asarray(centre, float), EVERYWHERE, make_plates(walls), 1)
    return flows[0, -1] if centre[3] else flows[0, 0]


def solid_angle(shape, point, height):
    """Of a flat shape at a height, holes and parts included, seen from below."""
    total = 0.0
    for part in shapely.get_parts(shape):
        for ring in (part.exterior, *part.interiors) if part.area else ():
            flat = shapely.get_coordinates(ring)[:-1]
            corners = np.column_stack([flat, np.full(len(flat), height)]) - point
            angle = SphericalHarmonics(1).polygon_integral(corners)[0] * np.sqrt(4 * np.pi)
            total += (
                abs(angle) if ring is part.exterior or ring.equals(part.exterior) else -abs(angle)
            )
    return total


@pytest.mark.parametrize("seed", range(6))
def test_what_walls_leave_of_a_window_is_a_difference_of_polygons(seed):
    rng = np.random.default_rng(seed)
    triangles = rng.uniform((0, 0, 0.5), (5, 5, 3.8), (6, 3, 3))
    points = rng.uniform((0, 0, -2), (5, 5, 0.4), (15, 3))
    way = unit((0.3, 0.2, 1.0))
    for centre in [*np.column_stack([points, np.ones(15)]), np.append(-way, 0.0)]:
        shadows = []
        for triangle in triangles:
            # From the centre through each corner to the window's plane, which lies beyond all.
            rays = triangle - centre[:3] if centre[3] else np.tile(way, (3, 1))
            onto = triangle + ((4 - triangle[:, 2]) / rays[:, 2])[:, None] * rays
            shadows.append(shapely.Polygon(onto[:, :2]))
        seen = shapely.difference(shapely.Polygon(WINDOW[:, :2]), shapely.union_all(shadows))
        exact = solid_angle(seen, centre[:3], 4.0) if centre[3] else seen.area * way[2]
        assert seen_of(WINDOW, centre, list(triangles)) == pytest.approx(exact, abs=1e-10)


def test_a_wall_edge_on_or_behind_the_window_hides_nothing():
    edge_on = rectangle((2, 0, 0.5), (0, 4, 0), (0, 0, 1))
    beyond, below = moved(WINDOW, z=0.5), moved(WINDOW, z=-6)
    centre = [2.0, 2.0, 0.0, 1.0]
    free = seen_of(WINDOW, centre, [])
    assert seen_of(WINDOW, centre, [edge_on, beyond, below, WINDOW]) == pytest.approx(
        free, abs=ROUNDING
    )


def test_many_walls_leave_many_pieces():
    """A grating of 200 slats: more pieces than there was room for at first."""
    window = rectangle((0, 0, 2), (2, 0, 0), (0, 2, 0))
    slats = [rectangle((0.01 * k, 0, 1), (0.005, 0, 0), (0, 2, 0)) for k in range(200)]
    assert seen_of(window, [0.0, 0.0, -1.0, 0.0], slats) == pytest.approx(2, abs=1e-11)


def test_polygons_fall_into_convex_parts():
    star = np.array(
        [(0, 0, 0), (2, 1, 0), (4, 0, 0), (3, 2, 0), (4, 4, 0), (2, 3, 0), (0, 4, 0), (1, 2, 0)],
        float,
    )
    angles = 2 * np.pi * np.arange(20) / 20
    disc = np.stack([np.cos(angles), np.sin(angles), 0 * angles + 3], axis=1)
    for outline in (star, disc, disc[[0, 3, 9]]):
        parts = convex_parts(outline)
        assert sum(map(polygon_area, parts)) == pytest.approx(polygon_area(outline))
        assert max(map(len, parts)) <= 8
        normals = make_plates(parts).planes[:, :3]
        np.testing.assert_allclose(normals, np.tile([0, 0, 1], (len(parts), 1)), atol=ROUNDING)
    assert polygon_area(clip_to_box(moved(disc, 1, 1), (1, 2, 9))) == pytest.approx(
        polygon_area(disc) / 2
    )
    assert len(clip_to_box(moved(disc, 9), (2, 2, 9))) == 0


def test_cut_faces_cover_the_faces():
    walls = [
        np.array([(0.3, 0.2, 0.1), (2.7, 1.1, 2.6), (0.9, 2.8, 1.4)]),
        *(v for v, _ in box((0.4, 1, 0.6), (1.7, 2, 1.8))),
    ]
    geometry = read_geometry(volume((3, 3, 3), walls=walls))
    whole, cut = cell_faces(geometry.grid), cut_faces(geometry.grid, geometry.walls)
    assert len(cut.groups) > len(whole.groups) + 50
    for panels in (whole, cut):
        corners = panels.corners
        crosses = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2
        # Each counter-clockwise round its normal, all six sides of a cell closed.
        np.testing.assert_allclose(
            crosses - np.linalg.norm(crosses, axis=1)[:, None] * panels.normals, 0, atol=1e-12
        )
        areas = np.bincount(panels.groups, np.linalg.norm(crosses, axis=1))
        np.testing.assert_allclose(areas, 6, rtol=1e-12)


def test_a_box_on_a_floor_leaves_a_floor_with_a_hole():
    floor = rectangle((0, 0, 0), (4, 0, 0), (0, 4, 0))
    walls = [floor, *(v for v, _ in box((1.2, 1.1, 0), (2.5, 2.3, 2)))]
    geometry = read_geometry(volume((4, 4, 4), walls=walls))
    sheets = cut_sheets(geometry.walls, geometry.surfaces, len(walls))
    areas = {}
    for sheet in sheets:
        areas.setdefault(sheet.surface, []).append(round(sheet.shape.area, 9))
    under = 1.3 * 1.2
    assert sorted(areas[0]) == [under, 16 - under]
    # The bottom of the box lies on the floor, which is the earlier one.
    assert sorted(areas) == [0, 1, 2, 3, 4, 6]


def test_walls_that_pass_through_one_another_are_cut():
    first, second = (
        rectangle((1, 1, 2), (2, 0, 0), (0, 2, 0)),
        rectangle((2, 1.5, 1), (0, 1, 0), (0, 0, 2)),
    )
    geometry = read_geometry(volume((4, 4, 4), walls=[first, second]))
    sheets = cut_sheets(geometry.walls, geometry.surfaces, 2)
    areas = [sorted(round(s.shape.area, 9) for s in sheets if s.surface == k) for k in (0, 1)]
    # The cut ends inside the first wall and is drawn on.
    assert areas == [[2, 2], [1, 1]]


def test_threads_change_nothing(monkeypatch):
    scene = volume(
        (4, 4, 4),
        [(rectangle((1, 1, 1), (1, 0, 0), (0, 1.5, 0.4)), 1.0)],
        [rectangle((1, 1, 2.2), (2, 0, 0), (0, 1, 0))],
        albedo=0.5,
    )
    answers = []
    for threads in ("1", "3"):
        monkeypatch.setenv("FLATLAND_THREADS", threads)
        assert thread_count() == int(threads)
        answers.append(Analytic(tolerance=1e-2).solve(scene, 2).values)
    np.testing.assert_allclose(answers[0], answers[1], atol=1e-13)
