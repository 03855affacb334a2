"""Shadow maps in 3D: who receives how much of a lamp's light, and where it goes from there."""

import numpy as np
import pytest
import trimesh
from shadow_maps import assert_books_of_colours, received
from walls3d import (
    CROSSING,
    GRID,
    POLYGONS,
    POSITION,
    SLANTED,
    SUN,
    facet,
    facets,
    normal_of,
    point_map,
    sun_map,
)

from flatland.facets import vector_area
from flatland.grid import Grid
from flatland.harmonics import SphericalHarmonics
from flatland.shadow_map import map_point_light, reflected_flux

ROUNDING = 1e-13


def share_of_sphere(vertices, position=POSITION):
    """Ω/4π of a polygon in cells, by the closed form of the harmonics."""
    seen = np.array(vertices, float) - position
    return abs(float(SphericalHarmonics(1).polygon_integral(seen)[0])) / np.sqrt(4 * np.pi)


EVERY_MAP = pytest.mark.parametrize("make", [point_map, sun_map])


@pytest.mark.parametrize("texels", [1, 7, 256])
@pytest.mark.parametrize("polygon", [SLANTED, *CROSSING], ids=["quad", "triangle", "another"])
def test_wall_before_a_point_receives_the_share_of_its_solid_angle(polygon, texels):
    # Exact at any number of texels: 1e-3 at 256 was asked for.
    found = point_map([facet(polygon)], texels=texels)
    expected = share_of_sphere(polygon)
    assert found.received.sum() == pytest.approx(expected, rel=1e-12)
    assert found.emitted == 1.0
    assert found.escaped == pytest.approx(1 - expected, rel=1e-12)


@pytest.mark.parametrize("distance", [1e-3, 0.3, 2.0])
def test_rectangle_before_a_point_has_its_known_solid_angle(distance):
    # Seen from above its middle: Ω = 4 atan(ab / (d √(a² + b² + d²))), half sides a and b.
    a, b = 3.0, 1.5
    z = 6.2 - distance
    corners = [(7.3 + x, 4.1 + y, z) for x, y in [(-a, -b), (a, -b), (a, b), (-a, b)]]
    angle = 4 * np.arctan(a * b / (distance * np.sqrt(a**2 + b**2 + distance**2)))
    found = point_map([facet(corners)]).received.sum()
    assert found == pytest.approx(angle / (4 * np.pi), rel=1e-12)


@pytest.mark.parametrize("texels", [1, 7, 256])
@pytest.mark.parametrize("polygon", [SLANTED, *CROSSING], ids=["quad", "triangle", "another"])
def test_wall_in_parallel_light_receives_its_projected_area(polygon, texels):
    expected = abs(vector_area(np.array(polygon)) @ SUN) * GRID.spacing**2
    found = sun_map([facet(polygon)], texels=texels).received.sum()
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("direction", "area"),
    [((1, 0, 0), 120), ((0, -1, 0), 160), ((0, 0, 1), 192), ((0.48, -0.6, -0.64), 276.48)],
)
def test_sun_sends_in_what_the_grid_is_wide_across_it(direction, area):
    found = sun_map([], direction)
    assert found.emitted == pytest.approx(area * GRID.spacing**2)
    assert found.escaped == found.emitted


@pytest.mark.parametrize("texels", [3, 8, 64])
def test_texel_of_a_point_light_holds_its_exact_solid_angle(texels):
    """The octree thesis, 3.3, puts 4 cos³θ tan²(FOV/2)/N² in its place: the midpoint rule."""
    room = [(0, 0, 0), (16, 0, 0), (16, 12, 0), (0, 12, 0)]
    found = point_map([facet(room)], (8.0, 6.0, 3.0), texels)
    per_texel = np.bincount(found.texels, 4 * np.pi * found.received, 6 * texels**2)
    borders = np.linspace(-1, 1, texels + 1)
    u, v = np.meshgrid(borders, borders, indexing="ij")
    corner = np.arctan(u * v / np.sqrt(1 + u**2 + v**2))
    exact = np.diff(np.diff(corner, axis=0), axis=1)
    assert exact.sum() == pytest.approx(4 * np.pi / 6)
    # The floor fills the lower face of the cube. Texels are counted face by face.
    faces = per_texel.reshape(6, texels, texels)
    (full,) = np.flatnonzero(np.all(faces > 0, axis=(1, 2)))
    np.testing.assert_allclose(faces[full], exact, rtol=1e-11)
    middle = 0.5 * (borders[1:] + borders[:-1])
    cosine = 1 / np.sqrt(1 + middle[:, None] ** 2 + middle**2)
    thesis = 4 * cosine**3 / texels**2
    error = np.abs(thesis / exact - 1).max()
    assert 0.3 / texels**2 < error < 1.5 / texels**2
    assert abs(thesis.sum() / exact.sum() - 1) < error


@EVERY_MAP
def test_number_of_texels_changes_no_flux(make):
    walls = facets()
    fine = received(make(walls, texels=256), walls)
    assert np.all(fine > 0)
    for texels in (1, 2, 5, 33):
        np.testing.assert_allclose(received(make(walls, texels=texels), walls), fine, atol=ROUNDING)


@EVERY_MAP
def test_number_of_texels_changes_no_cell(make):
    walls = facets()
    pieces = [make(walls, texels=texels) for texels in (1, 50)]
    fields = []
    for found in pieces:
        every = np.arange(len(found.walls))
        cells, shares, _ = found.cell_shares(every, found.received, GRID)
        field = np.zeros(GRID.shape)
        np.add.at(field, tuple(cells.T), shares)
        fields.append(field)
    np.testing.assert_allclose(fields[0], fields[1], atol=ROUNDING)


def test_shadow_takes_from_the_wall_behind_what_the_blocker_gets():
    behind = facet([(0, 0, 1), (16, 0, 1), (16, 12, 1), (0, 12, 1)])
    blocker = facet([(6, 3, 3), (9, 3, 3.5), (9, 6, 3.5), (6, 6, 3)])
    for make in (point_map, sun_map):
        alone, only = (received(make([wall]), [wall])[0] for wall in (behind, blocker))
        both = received(make([behind, blocker]), [behind, blocker])
        assert both[1] == pytest.approx(only, rel=1e-12)
        assert both[0] == pytest.approx(alone - only, rel=1e-12)


def test_crossing_walls_are_lit_up_to_where_they_cross():
    # Seen from above, an X shows the upper half of either arm.
    walls = [
        facet([(6, 2, 3), (10, 2, 7), (10, 8, 7), (6, 8, 3)]),
        facet([(10, 2, 3), (6, 2, 7), (6, 8, 7), (10, 8, 3)]),
    ]
    found = sun_map(walls, (0.0, 0.0, -1.0), texels=3)
    np.testing.assert_allclose(received(found, walls), [3.0, 3.0], atol=ROUNDING)
    assert GRID.to_cells(found.positions)[:, 2].min() > 5
    seen = [(8, 2, 5), (10, 2, 7), (10, 8, 7), (8, 8, 5)]
    halves = received(point_map(walls, (8, 5, 8.5)), walls)
    np.testing.assert_allclose(halves, share_of_sphere(seen, (8, 5, 8.5)), rtol=1e-12)


def test_what_is_outside_the_grid_or_seen_from_its_edge_has_no_effect():
    walls = [
        facet([(-3, -1, -1), (19, -1, -1), (19, 14, -1)]),
        facet([(17, 0, 0), (17, 12, 0), (17, 12, 10), (17, 0, 10)]),
        facet([(9, 4.1, 2), (12, 4.1, 2), (12, 4.1, 7)]),
    ]
    assert received(point_map(walls), walls).sum() == 0
    assert received(sun_map(walls, (1.0, 0.0, 0.0)), walls).sum() == 0
    assert received(sun_map(walls, (0.0, -1.0, 0.0)), walls)[2] == pytest.approx(7.5 / 4)


def test_part_of_a_wall_inside_the_grid_counts():
    outside = [facet([(-1000, -500, 2), (1e7, -500, 2), (1e7, 900, 2), (-1000, 900, 2)])]
    assert sun_map(outside, (0, 0, -1)).received.sum() == pytest.approx(48, rel=1e-10)


def test_of_two_walls_in_one_place_the_first_is_lit():
    quad, (a, b, c, d) = facet(SLANTED), SLANTED
    walls = [quad, facet(SLANTED[::-1]), facet((a, b, c)), facet((c, d, a))]
    for found in (point_map(walls), sun_map(walls)):
        assert set(found.walls) == {0}


def test_faces_that_touch_share_the_light_without_gap_or_overlap():
    # Two boxes with a common face: what is seen of both is what is seen of the long box.
    room = Grid((12, 12, 12))
    parts = [
        trimesh.creation.box(bounds=b) for b in ([[2, 2, 2], [5, 5, 5]], [[5, 2, 2], [9, 5, 5]])
    ]
    whole = trimesh.creation.box(bounds=[[2, 2, 2], [9, 5, 5]])
    walls = [facet(t, grid=room) for part in parts for t in part.triangles]
    alone = [facet(t, grid=room) for t in whole.triangles]
    position = np.array([5.0, 9.3, 10.1])
    both, one = (map_point_light(room, w, position, 20) for w in (walls, alone))
    assert both.received.sum() == pytest.approx(one.received.sum(), rel=1e-12)


@EVERY_MAP
def test_pieces_lie_on_their_walls_and_face_the_light(make):
    walls = facets()
    found = make(walls)
    origins = np.array([walls[number].vertices[0] for number in found.walls])
    distance = np.sum((found.positions - origins) * found.normals, axis=1)
    np.testing.assert_allclose(distance, 0, atol=1e-12)
    light = GRID.to_world(POSITION) - found.positions if make is point_map else -SUN
    cosines = np.sum(found.normals * light, axis=1) / np.linalg.norm(light, axis=-1)
    assert (cosines > 0).all()
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1, atol=ROUNDING)
    np.testing.assert_allclose(found.cosines, cosines, atol=1e-12)
    count = 6 * 64**2 if make is point_map else 64**2
    assert 0 <= found.texels.min() < found.texels.max() < count


@EVERY_MAP
def test_sources_are_the_lit_parts_of_walls(make):
    walls = facets()
    found = make(walls)
    pieces = found.source_map()
    np.testing.assert_allclose(received(pieces, walls), received(found, walls), atol=ROUNDING)
    sources = pieces.sources(pieces.received[:, None], GRID)
    total = sum(float(source.spectrum[0]) for source in sources)
    assert total == pytest.approx(float(found.received.sum()), rel=1e-12)
    for source in sources:
        normal = normal_of(source.vertices)
        middle = source.vertices.mean(axis=0)
        light = GRID.to_world(POSITION) - middle if make is point_map else -SUN
        assert normal @ light > 0
        # Half a cell along each axis at most.
        assert np.ptp(source.vertices, axis=0).max() < 0.5 * GRID.spacing + 1e-9
        if make is sun_map:
            across = np.linalg.norm(vector_area(source.vertices)) * (normal @ -SUN)
            assert source.spectrum[0] == pytest.approx(across, rel=1e-6, abs=1e-12)


@EVERY_MAP
def test_budget_of_a_coloured_lamp_among_coloured_walls(make):
    albedos = [(0.5, 0.0, 1.0), 0.25, (0.1, 0.2, 0.3), 0.0, 1.0]
    walls = [facet(*pair) for pair in zip(POLYGONS, albedos)]
    assert_books_of_colours(make(walls), walls, np.array([1.0, 2.0, 0.0]))


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.3])
def test_lpv2009_is_darker_by_the_cosine_of_a_tilted_wall(angle):
    along = 2.0 * np.array([np.cos(angle), 0.0, np.sin(angle)])
    corners = [np.array([8, y, 5]) + sign * along for y, sign in [(3, -1), (3, 1), (7, 1), (7, -1)]]
    walls = [facet(corners)]
    found = sun_map(walls, (0.0, 0.0, -1.0))
    exact, dark = (reflected_flux(found, walls, np.ones(1), w).sum() for w in ("exact", "lpv2009"))
    assert dark / exact == pytest.approx(np.cos(angle), rel=1e-12)


def test_lpv2009_weights_a_point_light_by_its_cosine():
    # ∫ cos θ dΩ over a disk's cone of half angle α is π sin²α; a polygon of many sides is a disk.
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    circle = [(8 + 3 * np.cos(a), 6 + 3 * np.sin(a), 2.0) for a in angles]
    walls = [facet(circle)]
    exact = 0.5 * 0.25 * np.sin(np.arctan(1.0)) ** 2
    errors = []
    for texels in (32, 64, 128):
        found = reflected_flux(point_map(walls, (8, 6, 5), texels), walls, np.ones(1), "lpv2009")
        errors.append(abs(found.sum() / exact - 1))
    assert errors[-1] < 1e-3, errors


@pytest.mark.parametrize(("radius", "texels"), [(4.0, 16), (0.05, 1)], ids=["large", "dense"])
def test_convex_mesh_throws_the_shadow_of_its_silhouette(radius, texels):
    """Cauchy: half of Σ A |n·ω|. The dense one has all its triangles in one tile of the map."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    walls = [facet(triangle) for triangle in mesh.triangles + np.array([8, 6, 5])]
    assert len(walls) == 5120
    found = sun_map(walls, texels=texels)
    expected = 0.5 * np.sum(mesh.area_faces * np.abs(mesh.face_normals @ SUN))
    assert found.received.sum() == pytest.approx(expected * GRID.spacing**2, rel=1e-10)
    facing = mesh.face_normals @ SUN < 0
    np.testing.assert_array_equal(np.unique(found.walls), np.flatnonzero(facing))


def test_many_walls_in_one_tile_that_all_are_wide(rng):
    # Splitting tiles would not help here, and must not be tried again and again.
    heights = rng.uniform(0.5, 3.5, 150)
    corners = [(0, 0), (16, 0), (16, 12), (0, 12)]
    walls = [facet([(*corner, height) for corner in corners]) for height in heights]
    top = np.argmax(heights)
    for make in (point_map, lambda w, texels=64: sun_map(w, (0, 0, -1), texels)):
        found = received(make(walls, texels=1), walls)
        alone = make([walls[top]]).received.sum()
        np.testing.assert_allclose(found, alone * (np.arange(150) == top), atol=1e-12)
