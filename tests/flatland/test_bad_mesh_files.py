"""Meshes from files: what is refused, and how large they may be."""

import contextlib
import os
import struct

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from meshes import BALL, BOX, FORMATS, exported, facets, off, scene_with, table

from flatland.occluders import meshfile
from flatland.scene import SceneError


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
