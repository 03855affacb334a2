"""Mistakes in scenes: each is named, with its place, and all are named at once."""

import pytest

from flatland.scene import SceneError, parse_scene

HEAD = "[grid]\nshape = [17, 17]\n"
SPACE = HEAD.replace("17]", "17, 17]")
AREA = '[[light]]\nkind = "area"\nstart = [2, 2]\nend = [4, 2]\nflux = 1\n'
POLYGON = '[[light]]\nkind = "area"\nvertices = [[2, 2, 1], [4, 2, 1], [4, 5, 1]]\nflux = 1\n'
CELL = '[[light]]\nkind = "cell"\ncell = [1, 1]\nflux = 1\n'
WALL = '[[light]]\nkind = "wall"\nside = "left"\nflux = 1\n'
POINT = '[[light]]\nkind = "point"\nposition = [5, 5]\nflux = 1\n'
SUN = '[[light]]\nkind = "directional"\ndirection = [1, -2]\nirradiance = 1\n'
SKY = '[[light]]\nkind = "environment"\nradiance = 1\n'
CIRCLE = '[[occluder]]\nkind = "circle"\ncenter = [5, 9]\nradius = 2\n'
SEGMENT = '[[occluder]]\nkind = "segment"\nstart = [2, 2]\nend = [4, 2]\n'
QUAD = '[[occluder]]\nkind = "quad"\nvertices = [[3, 2, 2], [7, 2, 2], [7, 5, 2], [3, 5, 2]]\n'
MESH = '[[occluder]]\nkind = "mesh"\nfile = "none.stl"\n'


def mistakes(text, **keywords):
    """The message for a scene that must not load."""
    with pytest.raises(SceneError) as caught:
        parse_scene(text, **keywords)
    return str(caught.value)


#: Text, and what the message must say.
MISTAKES = {
    "not a number": (HEAD + AREA.replace("[2, 2]", '["2", 2]'), "light 1, start = ['2', 2]"),
    "truth value as number": (HEAD + AREA.replace("= 1", "= true"), "light 1, flux = True"),
    "NaN": (HEAD + AREA.replace("= 1", "= nan"), "light 1, flux = nan: must be"),
    "infinity": (HEAD + SEGMENT.replace("[4, 2]", "[inf, 2]"), "occluder 1, end = [inf, 2]"),
    "far too large": (HEAD + AREA.replace("= 1", "= 1e200"), "at most 1e+100"),
    "negative flux": (HEAD + AREA.replace("= 1", "= -1"), "flux = -1: must be at least 0"),
    "no colours": (HEAD + AREA.replace("= 1", "= []"), "flux = []"),
    "too many coordinates": (HEAD + AREA.replace("[2, 2]", "[2, 2, 2]"), "2 numbers, [x, y]"),
    "zero length": (HEAD + AREA.replace("[4, 2]", "[2, 2]"), "a light needs a length"),
    "neither flux nor radiance": (HEAD + AREA.replace("flux = 1", ""), "either flux or radiance"),
    "flux and radiance": (HEAD + AREA + "radiance = 1", "either flux or radiance"),
    "outside": (HEAD + AREA.replace("[4, 2]", "[4, 17.1]"), "end = [4.0, 17.1]: must lie in the"),
    "light leaves": (HEAD + AREA.replace("2]", "17]"), "half a cell in front"),
    "cell outside": (HEAD + CELL.replace("[1, 1]", "[1, 17]"), "0 to 16, 0 to 16"),
    "negative cell": (HEAD + CELL.replace("[1, 1]", "[1, -1]"), "cell = [1, -1]"),
    "fraction of a cell": (HEAD + CELL.replace("[1, 1]", "[1, 1.0]"), "whole number"),
    "zero direction": (HEAD + CELL + "direction = [0, 0.0]", "direction = [0, 0.0]: must not be"),
    "unknown side": (HEAD + WALL.replace("left", "up"), "accepted: 'left', 'right'"),
    "side of 3D": (HEAD + WALL.replace("left", "back"), "accepted: left, right, bottom, top"),
    "last before first": (HEAD + WALL + "first = 3\nlast = 2", "last = 2: must be at least"),
    "two directions": (HEAD + WALL + "isotropic = true\ndirection = [1, 0]", "isotropic"),
    "truth value as text": (HEAD + WALL + 'isotropic = "yes"', "must be true or false"),
    "point outside": (HEAD + POINT.replace("5, 5", "5, 18"), "light 1, position = [5.0, 18.0]: mu"),
    "point on the border": (HEAD + POINT.replace("5, 5", "0, 5"), "must lie inside the grid"),
    "point in 3D": (HEAD + POINT.replace("5, 5", "5, 5, 5"), "must be 2 numbers"),
    "point on an occluder": (
        HEAD + POINT + POINT.replace("5, 5", "3, 2") + SEGMENT,
        "line 9: light 2, position = [3.0, 2.0]: must not lie on an occluder",
    ),
    "no flux": (HEAD + POINT.replace("flux = 1", ""), "has no key 'flux'"),
    "unknown part": (HEAD + POINT + 'inject = "all"', "inject = 'all': is none of the choices"),
    "unknown weight": (HEAD + POINT + 'weight = "2009"', "'exact' or 'lpv2009'"),
    "no texels": (HEAD + POINT + "texels = 0", "texels = 0: must be a whole number from 1 to"),
    "key by its inner name": (HEAD + POINT + 'part = "both"', "part = 'both': is an unknown key"),
    "sun without direction": (HEAD + SUN.replace("1, -2", "0, 0"), "must not be zero in all"),
    "sun in 3D": (HEAD + SUN.replace("1, -2", "1, -2, 3"), "must be 2 numbers"),
    "dark sun": (HEAD + SUN.replace("ance = 1", "ance = -1"), "irradiance = -1: must be at least"),
    "dark sky": (HEAD + SKY.replace("= 1", "= [1, -1]"), "radiance = [1, -1]: must be at least 0"),
    "circle without radius": (HEAD + CIRCLE.replace("= 2", "= 0"), "radius = 0: must be greater"),
    "circle inside out": (HEAD + CIRCLE.replace("= 2", "= -2"), "radius = -2: must be greater"),
    "circle too small": (HEAD + CIRCLE.replace("= 2", "= 1e-20"), "must be larger"),
    "circle of two sides": (HEAD + CIRCLE + "segments = 2", "a whole number from 3 to 65536"),
    "unknown kind": (
        HEAD + '[[light]]\nkind = "aera"',
        "did you mean 'area'?; accepted: area, cell",
    ),
    "no kind": (
        HEAD + "[[occluder]]\nstart = [1, 2]",
        "no key 'kind'; accepted: box, circle, mesh, polygon, quad, segment",
    ),
    "kind is no text": (HEAD + "[[light]]\nkind = [1]", "light 1, kind = [1]"),
    "missing key": (HEAD + '[[light]]\nkind = "cell"\nflux = 1', "has no key 'cell'"),
    "unknown key of a light": (
        HEAD + CELL + "fulx = 2",
        "did you mean 'flux'?; accepted: kind, cell",
    ),
    "unknown key of the grid": (HEAD + "size = 2", "grid, size = 2: is an unknown key"),
    "unknown table": (HEAD + "[[lights]]", "did you mean 'light'?; accepted: title, grid, light"),
    "light is no list": (HEAD + "[light]\nflux = 1", "each begun with [[light]]"),
    "light is no table": ("light = [1]\n" + HEAD, "light 1 = 1: must be a table"),
    "grid is no table": ("grid = 5", "grid = 5: must be a table"),
    "no grid": ('title = "x"', "has no key 'grid'"),
    "title is no text": (
        "title = 1979-05-27\n" + HEAD,
        "title = datetime.date(1979, 5, 27): must be",
    ),
    "one axis": (HEAD.replace("17, ", ""), "2 or 3 numbers of cells"),
    "no cells": (HEAD.replace("17, ", "0, "), "shape = [0, 17]: must be a whole number from 1"),
    "fraction of cells": (HEAD.replace("17, ", "17.0, "), "shape = [17.0, 17]"),
    "no spacing": (HEAD + "spacing = 0", "spacing = 0: must be greater than 0"),
    "negative spacing": (HEAD + "spacing = -1", "spacing = -1: must be greater than 0"),
    "origin in 3D": (HEAD + "origin = [0, 0, 0]", "origin = [0.0, 0.0, 0.0]: must be 2 numbers"),
    "too large a grid": (HEAD.replace("17, ", "99999999, "), "needs 19.00 GiB"),
    "absurd grid": (HEAD.replace("17, ", f"{10**30}, "), "to 2147483647"),
    "more absurd grid": (HEAD.replace("17, ", f"0x{'f' * 5000}, "), "too long to show"),
    "too many colours for memory": (
        HEAD.replace("17, 17", "30000, 30000") + CELL.replace("= 1", f"= {[1] * 50}"),
        "line 2: grid, shape = [30000, 30000]: needs 502.91 GiB",
    ),
    "segment light in 3D": (
        SPACE + AREA,
        "start = [2.0, 2.0]: is for 2D, the grid is 3D: write vertices = [[x, y, z], ...]",
    ),
    "polygon light in 2D": (
        HEAD + POLYGON,
        "are for 3D, the grid is 2D: write start = [x, y] and end = [x, y] instead",
    ),
    "area light without a shape": (
        HEAD + POLYGON.replace("vertices", "# "),
        "light 1 = {'kind': 'area', 'flux': 1}: needs a start and an end in 2D, or vertices in 3D",
    ),
    "area light without an end": (HEAD + AREA.replace("end", "# "), "has no key 'end', which it"),
    "area light of two shapes": (
        SPACE + POLYGON + "start = [2, 2]",
        "light 1, vertices = [[2.0, 2.0, 1.0], [4.0, 2.0, 1.0], [4.0, 5.0, 1.0]]: cannot be "
        "combined with start, which",
    ),
    "two vertices": (SPACE + POLYGON.replace("[4, 2, 1], ", ""), "at least 3 points [x, y, z]"),
    "flat vertices": (SPACE + POLYGON.replace("4, 2, 1", "4, 2"), "at least 3 points [x, y, z]"),
    "vertices on a line": (SPACE + POLYGON.replace("4, 5", "8, 2"), "its points lie on one line"),
    "vertex given twice": (
        SPACE + POLYGON.replace("4, 5", "2, 2"),
        "has the same point as vertex 3 and vertex 1; the outline closes itself",
    ),
    "polygon outside": (
        SPACE + POLYGON.replace("5, 1", "18, 1"),
        "light 1, vertices = [4.0, 18.0, 1.0]: must lie in the grid, [0, 17] x [0, 17] x [0, 17]",
    ),
    "polygon light leaves": (
        SPACE + POLYGON.replace("1]", "17]"),
        "where its vertices run counter-clockwise; move the polygon inwards or reverse",
    ),
    "quad of three": (SPACE + QUAD.replace(", [3, 5, 2]", ""), "a list of 4 points [x, y, z]"),
    "quad out of plane": (
        SPACE + QUAD.replace("3, 5, 2", "3, 5, 2.1"),
        "occluder 1, vertices = [[3.0, 2.0, 2.0], [7.0, 2.0, 2.0], [7.0, 5.0, 2.0], "
        "[3.0, 5.0, 2.1]]: must lie in one plane: vertex ",
    ),
    "quad with crossing edges": (
        SPACE + QUAD.replace("[7, 5, 2], [3, 5, 2]", "[3, 5, 2], [7, 5, 2]"),
        "must be given in order round its outline: its edges cross or touch",
    ),
    "mesh of a wrong kind": (
        SPACE + MESH.replace("none.stl", "room.glb"),
        "occluder 1, file = 'room.glb': must be the name of a mesh file; accepted: .stl, .obj",
    ),
    "mesh that is not there": (SPACE + MESH, "occluder 1, file = 'none.stl': is not a file"),
    "mesh without size": (SPACE + MESH + "scale = 0", "scale = 0: must be greater than 0"),
    "mesh put nowhere": (
        SPACE + MESH + "position = [1, 2]",
        "position = [1, 2]: must be 3 numbers",
    ),
    "mesh by its inner name": (SPACE + MESH + "thin = true", "thin = True: is an unknown key"),
    "2D occluder in 3D": (SPACE + SEGMENT, "exists in 2D, the grid is 3D"),
    "3D occluder in 2D": (HEAD + QUAD, "exists in 3D, the grid is 2D"),
    "empty": ("", "is empty"),
    "only comments": ("# nothing\n", "is empty"),
    "syntax": (HEAD + "flux == 3", "scene, line 3: text = 'flux == 3': is not valid TOML"),
    "open text": (HEAD + 'title = "abc', "line 3"),
    "key given twice": (HEAD + "shape = [3, 3]", "is not valid TOML"),
    "number of 5000 digits": (HEAD + f"spacing = {'9' * 5000}", "cannot be read as TOML"),
    "deep nest": ("a = " + "[" * 5000, "cannot be read as TOML"),
    "deep key": (".".join("a" * 5000) + " = 1", "nested too deeply"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00", "scene, line 1: bytes = b'\\x89PNG"),
}


@pytest.fixture(autouse=True)
def _small_machine(monkeypatch):
    """A machine with 16 GiB, wherever the tests run."""
    monkeypatch.setattr("flatland.memory.available_memory", lambda: 16 * 2**30)


@pytest.mark.parametrize(("text", "said"), MISTAKES.values(), ids=MISTAKES)
def test_mistake_is_named(text, said):
    message = mistakes(text)
    assert said in message
    assert "\n" not in message


def test_all_mistakes_are_named_at_once_each_with_its_line():
    text = (
        "title = 5\n"  # 1
        "[grid]\n"
        "shape = [17, 17]\n"
        "[[light]]\n"
        'kind = "area"\n'
        "start = [1, 20]\n"  # 6
        "end = [1, -2]\n"  # 7
        "flux = [1, 1]\n"
        "[[light]] # the second\n"
        'kind = "cell"\n'
        "cell = [1, 1]\n"
        "flux = [1, 1, 1]\n"  # 12
        "[[occluder]]\n"
        'kind = "segment"\n'
        "start = [1, 1]\n"  # end is missing from the table in line 13
        "albedo = 2\n"  # 16
    )
    with pytest.raises(SceneError) as caught:
        parse_scene(text, "my.toml")
    found = {problem.line: str(problem) for problem in caught.value.problems}
    assert sorted(found) == [1, 6, 7, 12, 13, 16]
    assert found[6].startswith(
        "my.toml, line 6: light 1, start = [1.0, 20.0]: must lie in the grid"
    )
    assert "3 colours where the scene so far has 2" in found[12]
    assert str(caught.value).count("\n") == 5


def test_problems_name_their_key():
    with pytest.raises(SceneError) as caught:
        parse_scene(HEAD + CELL + CELL.replace("= 1", "= -1"))
    assert [problem.key for problem in caught.value.problems] == [("light", 2, "flux")]


def test_albedo_counts_as_colour():
    text = HEAD + AREA.replace("= 1", "= [1, 2]") + SEGMENT + "albedo = [0, 0, 1]"
    assert "occluder 1, albedo = [0.0, 0.0, 1.0]: has 3 colours" in mistakes(text)


def test_many_mistakes_are_counted():
    assert mistakes(HEAD + "[[light]]\n" * 50).endswith("... and 30 more mistakes")


def test_light_on_the_border_within_rounding_is_fine():
    assert parse_scene(HEAD + AREA.replace("2]", "0]").replace("[4, 0]", "[4, -1e-12]")).lights


def test_occluders_may_stick_out_of_the_grid():
    assert parse_scene(HEAD + SEGMENT.replace("[4, 2]", "[1e9, -5]")).occluders
