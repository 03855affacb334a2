"""Analytic reference in 3D: flows of polygons, and polygons with shadows taken out of them."""

import numpy as np
import pytest
import shapely
from volumes import box, moved, rectangle, unit, volume

from flatland.harmonics import SphericalHarmonics
from flatland.kernels.threads import thread_count
from propagators.analytic import Analytic
from propagators.analytic.compiling import shared
from propagators.analytic_3d.cuts import ROOM
from propagators.analytic_3d.faces import cell_faces, cut_faces
from propagators.analytic_3d.flow import add_polygon, flow_tables
from propagators.analytic_3d.geometry import read_geometry
from propagators.analytic_3d.maps import cosine_maps, polygon_map, series_bands, series_map
from propagators.analytic_3d.plates import clip_to_box, convex_parts, make_plates, polygon_area
from propagators.analytic_3d.shadows import EVERYWHERE, collect_blockers, make_work, see
from propagators.analytic_3d.sheets import cut_sheets
from propagators.analytic_3d.windows import area_across

ROUNDING = 1e-13


@shared
def flows_of(polygons, tables, size):
    result = np.zeros((polygons.shape[0], size))
    harmonics = np.empty(tables.diagonal.size**2)
    for k in range(polygons.shape[0]):
        add_polygon(polygons[k].copy(), polygons.shape[1], tables, harmonics, result[k])
    return result


@shared
def areas_seen(centres, window, plane, walls):
    """Area across parallel light, or solid, that walls leave of a window from each centre."""
    work = make_work(walls.planes.shape[0])
    pieces, sizes = np.empty((64, ROOM, 3)), np.empty(64, np.int64)
    result, counts = np.zeros(len(centres)), np.zeros(len(centres), np.int64)
    for k in range(len(centres)):
        found = collect_blockers(
            centres[k : k + 1], window, window.shape[0], plane, EVERYWHERE, walls, work
        )
        pieces, sizes, left, _ = see(
            centres[k], window, window.shape[0], found, work, pieces, sizes
        )
        counts[k] = left
        for p in range(left):
            result[k] += area_across(pieces[p], sizes[p], np.array([0.0, 0.0, 1.0, 0.0]))
    return result, counts


def spherical_polygons(rng, count, corners=5):
    """Convex, round random axes, less than a quarter turn wide."""
    axis = rng.normal(size=(count, 1, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    first = np.cross(axis, rng.normal(size=(count, 1, 3)))
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    angles = np.sort(rng.uniform(0, 2 * np.pi, (count, corners)), axis=1)[..., None]
    second = np.cross(axis, first)
    return axis + 0.8 * (np.cos(angles) * first + np.sin(angles) * second)


@pytest.mark.parametrize("bands", [1, 2, 3, 6])
def test_flows_are_the_integrals_of_the_basis(bands, rng):
    polygons, tables = spherical_polygons(rng, 40), flow_tables(bands)
    flows = flows_of(polygons, tables, tables.size)
    wide = SphericalHarmonics(bands + 1)
    expected = wide.polygon_integral(polygons)
    np.testing.assert_allclose(flows @ polygon_map(bands + 1).T, expected, atol=ROUNDING)
    basis, up = SphericalHarmonics(bands), np.all(polygons[..., 2] > 0, axis=1)
    assert up.sum() > 3
    normals = np.tile([0.0, 0.0, 1.0], (up.sum(), 1))
    expected = basis.polygon_cosine_integral(polygons[up], normals)
    np.testing.assert_allclose(flows[up] @ cosine_maps(bands)[2].T, expected, atol=ROUNDING)


@pytest.mark.parametrize("length", [1, 4, 9])
def test_series_times_harmonics_are_the_gram_matrix_of_the_polygon(length, rng):
    polygons, series = spherical_polygons(rng, 10), rng.normal(size=length)
    bands = series_bands(3, series)
    flows = flows_of(polygons, flow_tables(bands), flow_tables(bands).size)
    gram = SphericalHarmonics(3).polygon_gram(polygons)
    expected = gram[:, :, :length] @ series
    np.testing.assert_allclose(flows @ series_map(3, series).T, expected, atol=ROUNDING)


@pytest.mark.parametrize("seed", range(6))
def test_what_walls_leave_of_a_window_is_a_difference_of_polygons(seed):
    rng = np.random.default_rng(seed)
    window = np.array([(1, 1, 4), (4, 0.5, 4), (5, 3, 4), (2, 4, 4)], float)
    triangles = rng.uniform((0, 0, 0.5), (5, 5, 3.8), (6, 3, 3))
    walls, plane = make_plates(list(triangles)), np.array([0.0, 0.0, -1.0, -4.0])
    points = rng.uniform((0, 0, -2), (5, 5, 0.4), (30, 3))
    way = unit((0.3, 0.2, 1.0))
    centres = np.vstack([np.column_stack([points, np.ones(30)]), [*-way, 0.0]])
    found, counts = areas_seen(centres, window, plane, walls)
    for k, centre in enumerate(centres):
        shadows = []
        for triangle in triangles:
            # From the centre through each corner to the window's plane, which lies beyond all.
            rays = triangle - centre[:3] if centre[3] else np.tile(way, (3, 1))
            onto = triangle + ((4 - triangle[:, 2]) / rays[:, 2])[:, None] * rays
            shadows.append(shapely.Polygon(onto[:, :2]))
        seen = shapely.difference(shapely.Polygon(window[:, :2]), shapely.union_all(shadows))
        assert found[k] == pytest.approx(seen.area, abs=1e-10)
    assert counts.max() > 4


def test_a_wall_edge_on_or_behind_the_window_hides_nothing():
    window, plane = rectangle((0, 0, 2), (2, 0, 0), (0, 2, 0)), np.array([0.0, 0.0, -1.0, -2.0])
    edge_on = rectangle((1, 0, 0.5), (0, 2, 0), (0, 0, 1))
    behind = rectangle((0, 0, 2.5), (2, 0, 0), (0, 2, 0))
    walls = make_plates([edge_on, behind, window])
    found, _ = areas_seen(np.array([[1.0, 1.0, 0.0, 1.0]]), window, plane, walls)
    assert found[0] == 4


def test_many_walls_leave_many_pieces():
    """A grating of 200 slats: more pieces than there was room for at first."""
    window, plane = rectangle((0, 0, 2), (2, 0, 0), (0, 2, 0)), np.array([0.0, 0.0, -1.0, -2.0])
    slats = [rectangle((0.01 * k, 0, 1), (0.005, 0, 0), (0, 2, 0)) for k in range(200)]
    way = np.array([[0.0, 0.0, -1.0, 0.0]])
    found, counts = areas_seen(way, window, plane, make_plates(slats))
    assert counts[0] == 200
    assert found[0] == pytest.approx(2, abs=1e-11)


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
