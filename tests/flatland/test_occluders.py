"""Occluders: outlines and albedo."""

import numpy as np
import pytest
from pydantic import ValidationError

from flatland.occluders import (
    OCCLUDERS,
    BoxOccluder,
    CircleOccluder,
    PolygonOccluder,
    SegmentOccluder,
)

TRIANGLE = ((0.0, 0.0), (4.0, 0.0), (0.0, 3.0))


def test_segment_is_its_own_outline():
    (wall,) = SegmentOccluder(start=(1.0, 2.0), end=(-3.0, 50.0)).walls()
    np.testing.assert_array_equal([wall.start, wall.stop], [[1, 2], [-3, 50]])


def test_polygon_closes_itself():
    walls = PolygonOccluder(vertices=TRIANGLE).walls()
    assert sum(np.linalg.norm(wall.stop - wall.start) for wall in walls) == pytest.approx(12.0)
    np.testing.assert_array_equal(walls[-1].stop, walls[0].start)


@pytest.mark.parametrize("sides", [3, 4, 7, 64])
def test_circle_keeps_its_circumference_whatever_its_number_of_sides(sides):
    walls = CircleOccluder(center=(1.0, -2.0), radius=1.5, segments=sides).walls()
    lengths = [np.linalg.norm(wall.stop - wall.start) for wall in walls]
    assert len(lengths) == sides
    np.testing.assert_allclose(lengths, 2 * np.pi * 1.5 / sides, rtol=1e-12)
    np.testing.assert_array_equal(walls[-1].stop, walls[0].start)


def test_outline_of_a_circle_comes_closer_with_the_square_of_its_sides():
    sides, errors = np.array([8, 16, 32, 64]), []
    for count in sides:
        outline = CircleOccluder(center=(0.0, 0.0), radius=1.0, segments=int(count)).walls()
        middles = [0.5 * (wall.start + wall.stop) for wall in outline]
        errors.append(1 - np.linalg.norm(middles, axis=1).min())
    slope = np.polyfit(np.log(sides), np.log(errors), 1)[0]
    assert -2.1 < slope < -1.9, f"order {-slope:.2f}, errors {errors}"
    assert errors[-1] == pytest.approx((np.pi / 64) ** 2 / 3, rel=1e-2)


def test_circle_stays_within_its_extent_along_the_axes():
    walls = CircleOccluder(center=(3.0, 2.0), radius=2.0).walls()
    corners = np.array([wall.start for wall in walls])
    assert (corners.min(axis=0) > [1, 0]).all()
    assert (corners.max(axis=0) < [5, 4]).all()


@pytest.mark.parametrize("keys", [{"radius": 0.0}, {"radius": 1.0, "segments": 2}])
def test_bad_circle_is_refused(keys):
    with pytest.raises(ValidationError, match="radius|segments"):
        CircleOccluder(center=(0.0, 0.0), **keys)


@pytest.mark.parametrize(
    ("albedo", "colours", "expected"),
    [
        (0.5, 0, [0.5]),
        (0.5, 3, [0.5, 0.5, 0.5]),
        ((0.1, 0.2), 2, [0.1, 0.2]),
        ((0.1, 0.2), 0, [0.1, 0.2]),
    ],
)
def test_albedo_has_one_entry_per_colour(albedo, colours, expected):
    for wall in PolygonOccluder(vertices=TRIANGLE, albedo=albedo).walls(colours):
        np.testing.assert_array_equal(wall.albedo, expected)


@pytest.mark.parametrize("albedo", [-0.1, 1.1, float("nan"), "0.5", True, (), (0.5, 2.0)])
def test_albedo_outside_0_to_1_is_refused(albedo):
    with pytest.raises(ValidationError, match="albedo"):
        SegmentOccluder(start=(0.0, 0.0), end=(1.0, 0.0), albedo=albedo)


@pytest.mark.parametrize(
    "vertices",
    [
        TRIANGLE[:2],
        (*TRIANGLE, TRIANGLE[0]),
        (TRIANGLE[0], *TRIANGLE),
        ((0, 0), (1, float("inf")), (2, 0)),
        ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
        "triangle",
        5,
    ],
)
def test_bad_vertices_are_refused(vertices):
    with pytest.raises(ValidationError, match="vertices"):
        PolygonOccluder(vertices=vertices)


@pytest.mark.parametrize("end", [(1.0, 2.0), (1.0, 2.0 + 1e-15)])
def test_segment_without_length_is_refused(end):
    with pytest.raises(ValidationError, match="length"):
        SegmentOccluder(start=(1.0, 2.0), end=end)


@pytest.mark.parametrize("kind", OCCLUDERS)
def test_every_key_has_a_meaning(kind):
    assert all(field.description for field in OCCLUDERS[kind].model_fields.values())


@pytest.mark.parametrize("kind", OCCLUDERS)
def test_registry_name_is_the_kind(kind):
    assert OCCLUDERS[kind].model_fields["kind"].default == kind


def test_box_has_six_faces_that_look_outwards():
    box = BoxOccluder(min=(1.0, 2.0, 3.0), max=(2.0, 4.0, 6.0))
    middle, area = np.array([1.5, 3.0, 4.5]), 0.0
    for wall in box.walls():
        assert wall.closed
        normal = np.cross(wall.vertices[1] - wall.vertices[0], wall.vertices[2] - wall.vertices[1])
        assert (wall.vertices.mean(axis=0) - middle) @ normal > 0
        area += np.linalg.norm(normal)
    assert area == pytest.approx(2 * (2 + 3 + 6))


@pytest.mark.parametrize("corner", [(1.0, 5.0, 5.0), (0.0, 5.0, 5.0)])
def test_box_without_an_inside_is_refused(corner):
    with pytest.raises(ValidationError, match="greater than min along x"):
        BoxOccluder(min=(1.0, 1.0, 1.0), max=corner)
