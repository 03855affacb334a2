"""Meshes from files: what is read, which way it faces, and what is refused."""

import contextlib
import os
import pickle
import struct

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from flatland.occluders import MeshOccluder, meshfile
from flatland.scene import Scene, SceneError, parse_scene, scene_to_toml

BOX = trimesh.creation.box(extents=(1, 2, 3))
BALL = trimesh.creation.icosphere(subdivisions=2)
RING = trimesh.creation.torus(1.0, 0.4, major_sections=12, minor_sections=7)
FORMATS = {
    "a.stl": {"file_type": "stl"},
    "text.stl": {"file_type": "stl_ascii"},
    "a.obj": {"file_type": "obj"},
    "a.OBJ": {"file_type": "obj"},
    "a.ply": {"file_type": "ply"},
    "text.ply": {"file_type": "ply", "encoding": "ascii"},
    "a.off": {"file_type": "off"},
}
every_format = pytest.mark.parametrize("name", FORMATS)


def exported(mesh, name):
    content = mesh.export(**FORMATS[name])
    return content.encode() if isinstance(content, str) else content


def table(name, **keys):
    return {"kind": "mesh", "file": name, **keys}


def scene_with(directory, *tables):
    data = {"grid": {"shape": [4, 4, 4]}, "occluder": list(tables)}
    return Scene.from_dict(data, directory=directory)


def facets(directory, name, content, **keys):
    if isinstance(content, trimesh.Trimesh):
        content = exported(content, name)
    (directory / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return scene_with(directory, table(name, **keys)).facets()


def volume(walls):
    """Of closed surfaces with outward normals; negative if they point inwards."""
    return sum(np.linalg.det(wall.vertices) for wall in walls) / 6


def area(walls):
    corners = np.array([wall.vertices for wall in walls])
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(cross, axis=1).sum() / 2


def off(points, *faces):
    rows = [" ".join(map(str, row)) for row in (*points, *((len(f), *f) for f in faces))]
    return "\n".join(["OFF", f"{len(points)} {len(faces)} 0", *rows, ""])


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


def stl(triangles, claimed=None):
    """Binary STL, with the number of triangles that its header claims."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles) if claimed is None else claimed) + body


TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
SHEET = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
CONCAVE = [[2, 0, 0], [0.5, 0.5, 0], [0, 2, 0], [0, 0, 0], [1, 1, 1]]
NOISE = np.random.default_rng(1).bytes(2000)
TEXT = {name: exported(BOX, name) for name in FORMATS}
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

BAD_FILES = {
    "empty stl": ("a.stl", b"", "holds no triangles: it is empty, cut short, or no .stl file"),
    "empty obj": ("a.obj", b"", "holds no triangles"),
    "empty ply": ("a.ply", b"", "cannot be read as .ply"),
    "empty off": ("a.off", b"", "cannot be read as .off"),
    "noise as stl": ("a.stl", NOISE, "holds no triangles"),
    "noise as obj": ("a.obj", NOISE, "holds no triangles"),
    "noise as ply": ("a.ply", NOISE, "cannot be read as .ply"),
    "noise as off": ("a.off", NOISE, "it does not begin with OFF"),
    "another format": ("a.stl", TEXT["a.ply"], "holds no triangles"),
    "picture": ("a.obj", b"\x89PNG\r\n\x1a\n" + bytes(99), "holds no triangles"),
    "cut stl": ("a.stl", TEXT["a.stl"][:-9], "holds no triangles"),
    "cut text stl": ("text.stl", TEXT["text.stl"][:-20], "cut short: no endsolid"),
    "cut second solid": (
        "text.stl",
        TEXT["text.stl"] + b"\n" + TEXT["text.stl"][:-300],
        "cut short: no endsolid",
    ),
    "cut obj": ("a.obj", TEXT["a.obj"][:-20], "a face has less than its corners"),
    "cut ply": ("a.ply", TEXT["a.ply"][:-9], "cannot be read as .ply"),
    "cut text ply": ("text.ply", TEXT["text.ply"][:-20], "less than the 20 lines it declares"),
    "cut off": ("a.off", TEXT["a.off"][:-20], "less than 8 vertices and 12 faces"),
    "cut last line": ("a.off", TEXT["a.off"][:-3], "a face has less than its corners"),
    "stl claims what it lacks": ("a.stl", stl([TRIANGLE], 2**32 - 1), "holds no triangles"),
    "ply claims what it lacks": (
        "a.ply",
        TEXT["a.ply"].replace(b"vertex 8", b"vertex 99999999999"),
        "cannot be read as .ply",
    ),
    "off claims what it lacks": (
        "a.off",
        TEXT["a.off"].replace(b"8 12 0", b"8 99999999999 0"),
        "less than 8 vertices and 99999999999 faces",
    ),
    "points alone": ("a.obj", OBJ, "holds no triangles"),
    "points alone in ply": (
        "text.ply",
        TEXT["text.ply"].replace(b"element face 12", b"element face 0"),
        "holds no triangles",
    ),
    "corner 0": ("a.obj", OBJ + "f 0 1 2", "with corners that are not there: 1 of 1"),
    "corner beyond": ("a.obj", OBJ + "f 1 2 3\nf 1 2 4", "1 of 2, the first is number 2"),
    "corner before": ("a.obj", OBJ + "f -4 -2 -1", "with corners that are not there"),
    "corner of ply": (
        "text.ply",
        TEXT["text.ply"].replace(b"\n3 1 3 0\n", b"\n3 1 3 -1\n"),
        "with corners that are not there: 1 of 12, the first is number 1",
    ),
    "corner of off": ("a.off", off(TRIANGLE, [0, 1, 3]), "with corners that are not there"),
    "corner of 30 digits": ("a.obj", OBJ + f"f 1 2 {10**30}", "cannot be read as .obj"),
    "fraction of a corner": ("a.obj", OBJ + "f 1.5 2 3", "cannot be read as .obj"),
    "face of two": ("a.obj", OBJ + "f 1 2", "a face has less than its corners, or less than 3"),
    "vertex of two": ("a.obj", "v 0 0\n" + OBJ + "f 1 2 3", "less than 3 coordinates"),
    "words": ("a.obj", OBJ + "v 1 one 0\nf 1 2 3", "cannot be read as .obj"),
    "comma": ("text.stl", TEXT["text.stl"].replace(b"vertex 0.5", b"vertex 0,5"), "cannot be read"),
    "NaN": ("a.obj", OBJ + "v nan 0 0\nf 1 2 4", "coordinates that are not finite"),
    "NaN in stl": ("a.stl", stl([TRIANGLE, [[0, 0, np.nan]] * 3]), "that are not finite"),
    "infinity": ("a.off", off([*TRIANGLE, ["inf", 0, 0]], [0, 1, 3]), "that are not finite"),
    "beyond any number": ("a.obj", OBJ + "v 0 0 1e999\nf 1 2 4", "that are not finite"),
    "enormous": ("a.obj", OBJ + "v 0 0 1e200\nf 1 2 4", "coordinates of 1e+200 m; at most 1e+100"),
    "no area": (
        "a.obj",
        OBJ + "v 2 0 0\nf 1 2 3\nf 1 2 4\nf 2 2 3",
        "has triangles without area: 2 of 3, the first is number 2 at [0, 0, 0]",
    ),
    "a point": ("a.stl", stl([[[1, 2, 3]] * 3]), "without area: 1 of 1"),
    "twice": (
        "a.stl",
        stl([TRIANGLE, TRIANGLE[::-1]]),
        "there already (a wall is opaque from both sides): 1 of 2, the first is number 2",
    ),
    "flat": (
        "a.off",
        off(SHEET, [0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]),
        "lie flat on their neighbour",
    ),
    "concave polygon": (
        "a.off",
        off(CONCAVE, [0, 1, 2, 3], [3, 4, 0], [0, 4, 1], [1, 4, 2], [2, 4, 3]),
        "polygons that are not convex must be split into triangles",
    ),
}


@pytest.mark.parametrize(("name", "content", "rule"), BAD_FILES.values(), ids=BAD_FILES)
def test_bad_file_is_refused_in_one_line(tmp_path, name, content, rule):
    with pytest.raises(SceneError) as caught:
        facets(tmp_path, name, content)
    message = str(caught.value)
    assert message.startswith(f"scene: occluder 1, file = '{name}': ")
    assert rule in message
    assert "\n" not in message
    assert len(message) < 300


def projective_plane():
    """A closed surface with one side only, as far as its vertices tell: six of them, ten faces."""
    faces = ["012", "023", "034", "045", "051", "124", "235", "341", "452", "513"]
    corners = np.random.default_rng(3).normal(size=(6, 3)).round(3).tolist()
    return off(corners, *[[int(i) for i in face] for face in faces])


def test_a_surface_with_one_side_is_refused(tmp_path):
    with pytest.raises(SceneError, match="has one side only"):
        facets(tmp_path, "a.off", projective_plane())
    assert len(facets(tmp_path, "a.off", projective_plane(), open=True)) == 10


def test_bodies_without_a_clear_inside_are_refused(tmp_path):
    """Two boxes that share a side; in files of their own they are fine."""
    cube = trimesh.creation.box()
    other = cube.copy()
    other.apply_translation((1, 0, 0))
    with pytest.raises(SceneError, match="files of their own, or take it as thin walls"):
        facets(tmp_path, "a.stl", trimesh.util.concatenate([cube, other]))
    assert len(facets(tmp_path, "a.stl", cube)) + len(facets(tmp_path, "a.obj", other)) == 24


@pytest.mark.parametrize("name", ["none.stl", "folder.obj", "pipe.ply", "../none.off"])
def test_missing_file_is_refused(tmp_path, name):
    (tmp_path / "folder.obj").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    with pytest.raises(SceneError, match="occluder 1, file = .*is not a file"):
        scene_with(tmp_path, table(name))


def test_unreadable_file_is_refused(tmp_path, monkeypatch):
    def refuse(*arguments, **keywords):
        raise PermissionError(13, "Permission denied")

    (tmp_path / "a.stl").write_bytes(b"")
    monkeypatch.setattr("pathlib.Path.open", refuse)
    with pytest.raises(SceneError, match=r"cannot be read \(Permission denied\)"):
        scene_with(tmp_path, table("a.stl"))


@pytest.mark.parametrize("name", ["", ".stl ", "a.glb", "stl", "a\0.stl", 5, None, ["a.stl"]])
def test_name_that_is_no_mesh_file_is_refused(tmp_path, name):
    with pytest.raises(SceneError, match="occluder 1"):
        scene_with(tmp_path, {"kind": "mesh", "file": name})


def test_enormous_files_are_refused_unread(tmp_path, monkeypatch):
    monkeypatch.setattr(meshfile, "LARGEST_FILE", 2**20)
    with (tmp_path / "a.stl").open("wb") as file:
        file.truncate(2**20 + 1)
    with pytest.raises(SceneError, match="larger than the 1 MiB that a mesh file may have"):
        scene_with(tmp_path, table("a.stl"))


def test_too_many_triangles_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(meshfile, "MOST_TRIANGLES", 11)
    with pytest.raises(SceneError, match="holds 12 triangles; at most 11 can be read"):
        facets(tmp_path, "a.stl", BOX)


def test_meshes_that_do_not_fit_into_memory_are_refused(tmp_path, monkeypatch):
    (tmp_path / "a.stl").write_bytes(exported(BALL, "a.stl"))
    monkeypatch.setattr("flatland.memory.available_memory", lambda: 2**17)
    with pytest.raises(SceneError, match="of memory"):
        scene_with(tmp_path, table("a.stl"))


@pytest.mark.parametrize(("scale", "place"), [(1e101, 0.0), (1e99, 1e100), (1.0, -1.1e100)])
def test_coordinates_stay_below_the_largest(tmp_path, scale, place):
    with pytest.raises(SceneError, match="at most 1e|to 1e"):
        facets(tmp_path, "a.stl", BOX, scale=scale, position=[place, 0, 0])


@pytest.mark.parametrize("scale", [1e-90, 1e90])
def test_meshes_of_any_size_are_read(tmp_path, scale):
    walls = facets(tmp_path, "a.stl", BALL, scale=scale)
    scaled = [wall.vertices / scale for wall in walls]
    assert sum(map(np.linalg.det, scaled)) / 6 == pytest.approx(BALL.volume, rel=1e-6)


def test_a_mesh_that_its_place_rounds_away_is_refused(tmp_path):
    with pytest.raises(SceneError, match="without area"):
        facets(tmp_path, "a.stl", BALL, scale=1e-12, position=[5, 5, 5])


@settings(
    max_examples=150,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.sampled_from(list(FORMATS)), st.data())
def test_damage_anywhere_is_an_input_error_or_harmless(tmp_path, name, data):
    damaged = bytearray(TEXT[name])
    for _ in range(data.draw(st.integers(1, 3))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(SceneError):
        assert np.isfinite([w.vertices for w in facets(tmp_path, name, bytes(damaged))]).all()
