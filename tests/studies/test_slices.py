"""Where a plane cuts lights and walls."""

import numpy as np
import pytest
import trimesh

from flatland import Scene, load_scene
from studies.figures.slices import Slice, plane_data, section, shown_axes

#: Three teeth along x, upright at z = 1 + y / 2, cut by planes of y.
COMB = np.array([[0, 0], [6, 0], [6, 3], [5, 1], [4, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]])
COMB = np.column_stack([COMB, 1 + COMB[:, 1] / 2]).astype(float)


def ends(lines):
    """Sorted lines, each from its smaller end on."""
    return sorted(tuple(sorted(map(tuple, np.round(line, 12)))) for line in lines)


def test_a_polygon_that_is_not_convex_is_cut_in_pieces():
    expected = [((0, 2), (1, 2)), ((2, 2), (4.5, 2)), ((5.5, 2), (6, 2))]
    assert ends(section(COMB, 1, 2.0)) == expected
    assert ends(section(COMB[::-1], 1, 2.0)) == expected
    assert ends(section(COMB, 1, 0.5)) == [((0, 1.25), (6, 1.25))]


@pytest.mark.parametrize("place", [-0.1, 3.1])
def test_a_plane_beside_a_polygon_cuts_nothing(place):
    assert section(COMB, 1, place).shape == (0, 2, 2)


def test_edges_in_the_plane_are_part_of_the_cut():
    teeth = [((0, 2.5), (1, 2.5)), ((2, 2.5), (4, 2.5))]
    assert ends(section(COMB, 1, 3.0)) == teeth
    assert ends(section(np.add(COMB, [0, 1e-12, 0]), 1, 3.0, 1e-9)) == teeth
    # From above, the inner edge lies between two stretches that are inside.
    inner = section(COMB, 1, 1.0)
    covered = np.abs(np.diff(np.sort(inner[..., 0], axis=1), axis=1))
    assert covered.sum() >= 6 - 1e-12


def test_a_polygon_in_the_plane_is_cut_in_its_outline():
    flat = COMB * [1, 1, 0]
    outline = np.stack([flat, np.roll(flat, -1, axis=0)], axis=1)[..., :2]
    assert ends(section(flat, 2, 0.0)) == ends(outline)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_closed_surface_is_cut_in_closed_lines(axis):
    ball = trimesh.creation.icosphere(subdivisions=4)
    place = 0.3017
    lines = np.concatenate([section(np.array(t), axis, place) for t in ball.triangles])
    points, counts = np.unique(np.round(lines.reshape(-1, 2), 9), axis=0, return_counts=True)
    assert set(counts) == {2}
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), np.sqrt(1 - place**2), rtol=3e-3)
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(2 * np.pi * np.sqrt(1 - place**2), rel=3e-3)


def test_the_cornell_box_is_cut_in_its_room_lamp_and_blocks():
    data = plane_data(load_scene("cornell-3d"), Slice(2, 8))
    assert ends(data["lights"].values) == [((6, 15), (10, 15))]
    walls = ends(data["walls"].values)
    for room in (((0, 0), (0, 16)), ((0, 0), (16, 0)), ((0, 16), (16, 16)), ((16, 0), (16, 16))):
        assert room in walls
    # Top and two sides of each block.
    assert len(walls) == 4 + 3 + 3
    assert data.attrs["place"] == "z = 8.5 m"


@pytest.mark.parametrize(
    ("layer", "names"), [(Slice(0, 2), "yz"), (Slice(1, 1), "xz"), (None, "xy")]
)
def test_axes_and_middles_of_cells_are_those_of_the_layer(layer, names):
    shape, origin = ((4, 5, 6), (1.0, 2.0, 3.0)) if layer else ((4, 5), (1.0, 2.0))
    scene = Scene.from_dict({"grid": {"shape": shape, "spacing": 0.5, "origin": origin}})
    data = plane_data(scene, layer)
    assert "".join(data.attrs[key] for key in ("across", "up")) == names
    for axis, name in zip(shown_axes(layer), names):
        np.testing.assert_allclose(data[name], origin[axis] + 0.25 + 0.5 * np.arange(shape[axis]))
    assert data["walls"].shape == (0, 2, 2)
