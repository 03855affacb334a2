"""Meshes from files: what is read, and which way it faces."""

import pickle

import numpy as np
import pytest
import trimesh
from meshes import BALL, BOX, RING, every_format, exported, facets, off, scene_with, table, volume
from scipy.spatial import ConvexHull

from flatland.occluders import MeshOccluder
from flatland.scene import SceneError, parse_scene, scene_to_toml


def area(walls):
    corners = np.array([wall.vertices for wall in walls])
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(cross, axis=1).sum() / 2


@every_format
@pytest.mark.parametrize("mesh", [BOX, BALL, RING], ids=["box", "ball", "ring"])
def test_a_closed_mesh_faces_outwards(tmp_path, name, mesh):
    walls = facets(tmp_path, name, mesh)
    assert len(walls) == len(mesh.faces)
    assert all(wall.closed for wall in walls)
    assert volume(walls) == pytest.approx(mesh.volume, rel=1e-6)
    assert area(walls) == pytest.approx(mesh.area, rel=1e-6)


@every_format
def test_scale_comes_before_position(tmp_path, name):
    walls = facets(tmp_path, name, BOX, scale=2.0, position=[10, 20, 30])
    corners = np.concatenate([wall.vertices for wall in walls])
    np.testing.assert_allclose(corners.min(axis=0), [9, 18, 27])
    np.testing.assert_allclose(corners.max(axis=0), [11, 22, 33])


@pytest.mark.parametrize("name", ["a.stl", "a.off"])
@pytest.mark.parametrize("turn", ["all", "some"])
def test_bodies_are_turned_outwards_however_they_were_wound(tmp_path, name, turn, rng):
    mesh = RING.copy()
    chosen = np.ones(len(mesh.faces), bool) if turn == "all" else rng.random(len(mesh.faces)) < 0.5
    mesh.faces[chosen] = mesh.faces[chosen][:, ::-1]
    assert volume(facets(tmp_path, name, mesh)) == pytest.approx(RING.volume, rel=1e-6)


def test_each_of_several_bodies_has_its_own_outside(tmp_path):
    inner, beside = BOX.copy(), BALL.copy()
    inner.invert()
    beside.invert()
    beside.apply_translation((9, 0, 0))
    outer = trimesh.creation.box(extents=(4, 4, 4))
    bodies = [inner, outer, beside]
    walls = facets(tmp_path, "a.obj", trimesh.util.concatenate(bodies))
    whole = 6 + 64 + BALL.volume
    assert volume(walls) == pytest.approx(whole, rel=1e-6)


def test_bodies_may_touch_along_an_edge(tmp_path):
    cube = trimesh.creation.box()
    other = cube.copy()
    other.apply_translation((1, 1, 0))
    other.invert()
    walls = facets(tmp_path, "a.stl", trimesh.util.concatenate([cube, other]))
    assert volume(walls) == pytest.approx(2.0)


def test_an_open_mesh_is_taken_as_thin_walls_if_that_is_said(tmp_path):
    half = BALL.slice_plane([0, 0, 0.1], [0, 0, 1])
    with pytest.raises(SceneError, match="open = true"):
        facets(tmp_path, "a.stl", half)
    walls = facets(tmp_path, "a.stl", half, open=True)
    assert not any(wall.closed for wall in walls)
    assert area(walls) == pytest.approx(half.area, rel=1e-6)
    assert not any(wall.closed for wall in facets(tmp_path, "a.stl", BALL, open=True))


def test_the_number_of_open_edges_is_named(tmp_path):
    one_less = BOX.copy()
    one_less.update_faces(np.arange(12) != 3)
    with pytest.raises(SceneError, match="is open: 3 of its edges have no second triangle"):
        facets(tmp_path, "a.stl", one_less)


def test_polygons_become_fans(tmp_path):
    prism = [[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 3, 0], [-1, 1, 0]]
    points = [*prism, *((x, y, 2) for x, y, _ in prism)]
    sides = [[i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i] for i in range(5)]
    faces = [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], *sides]
    content = [f"v {x} {y} {z}" for x, y, z in points]
    content += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    expected = ConvexHull(points)
    for name, text in {"a.obj": "\n".join(content), "a.off": off(points, *faces)}.items():
        walls = facets(tmp_path, name, text)
        assert len(walls) == 2 * 3 + 5 * 2
        assert volume(walls) == pytest.approx(expected.volume)


def test_obj_may_look_as_its_writers_please(tmp_path):
    plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"
    fancy = (
        "# a comment\nmtllib none.mtl\no body\nv\t0 0 0 1 0 0\n  v 1 0 0\r\nv 0 1 \\\n0\nvn 0 0 1\n"
        "vt 0 0\nusemtl red # no\nf -3//1 -2//1 -1//1\nv 0 0 1\ns off\n"
        "f 1/1 4/1 2/1\nusemtl blue\nf 1/1/1\t3/1/1 4/1/1\ng other\nf 2 4 3\n"
    )
    one, other = (facets(tmp_path, "a.obj", text) for text in (plain, fancy))
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.vertices, b.vertices)
    assert volume(one) == pytest.approx(1 / 6)


def test_albedo_and_overlaps_are_as_for_any_occluder(tmp_path):
    (tmp_path / "a.stl").write_bytes(exported(BOX, "a.stl"))
    box = {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1], "albedo": 0.5}
    quad = {"kind": "quad", "vertices": [[-1, 0, 0], [1, 0, 0], [1, 1, 1], [-1, 1, 1]]}
    mesh = table("a.stl", albedo=[0.1, 0.2])
    scene = scene_with(tmp_path, mesh, box, mesh, quad)
    assert len(scene.facets()) == 12 + 6 + 12 + 1
    np.testing.assert_array_equal(scene.facets()[0].albedo, [0.1, 0.2])
    np.testing.assert_array_equal(scene.facets()[-1].albedo, [0, 0])


def test_scene_is_equal_only_if_the_meshes_are(tmp_path):
    (tmp_path / "a.stl").write_bytes(exported(BOX, "a.stl"))
    scene = scene_with(tmp_path, table("a.stl", scale=0.5, position=[1, 1, 1], open=True))
    again = parse_scene(scene_to_toml(scene), directory=tmp_path)
    assert again == scene
    assert hash(again) == hash(scene)
    assert pickle.loads(pickle.dumps(scene)) == scene
    (tmp_path / "a.stl").write_bytes(exported(BALL, "a.stl"))
    assert parse_scene(scene_to_toml(scene), directory=tmp_path) != scene


def test_the_file_is_read_once(tmp_path):
    scene_with(tmp_path)
    (tmp_path / "a.stl").write_bytes(exported(BOX, "a.stl"))
    scene = scene_with(tmp_path, table("a.stl"))
    (tmp_path / "a.stl").unlink()
    assert len(scene.facets()) == 12


def test_a_mesh_without_a_scene_is_looked_up_where_we_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.stl").write_bytes(exported(BOX, "a.stl"))
    assert len(MeshOccluder(file="a.stl").walls()) == 12
