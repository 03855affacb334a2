"""Geometry of items and strokes, without Qt."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatland.grid import Grid
from flatland.scene import Scene, builtin_names, load_scene
from gui.models import edits
from gui.models.camera import Camera
from gui.models.fields import REGISTRIES, specs_of_kind
from gui.models.plane import Plane
from gui.models.shapes import distance_to, drag_handle, handles_of, outline_of
from gui.models.toml_text import tables_of
from gui.models.tools import Brush, cells_along, constrained, line, snapped, stroke_tables
from gui.models.track import Row, Track, tracks_to_csv

GRID = Grid((12, 10), 0.5, (1.0, -2.0))
SOLID = Grid((6, 5, 4))
FLAT = Plane()


def kinds():
    return [
        (name, kind, dimension)
        for name, registry in REGISTRIES.items()
        for kind, model in registry.items()
        for dimension in model.dimensions
        if not any(spec.kind == "file" for spec in specs_of_kind(name, kind))
    ]


def grid_of(dimension):
    return GRID if dimension == 2 else SOLID


@pytest.mark.parametrize(("name", "kind", "dimension"), kinds())
def test_every_kind_can_be_added_from_what_it_declares(name, kind, dimension):
    grid = grid_of(dimension)
    table = edits.starting_table(name, kind, grid, Plane.of(grid))
    scene = Scene.from_dict({"grid": grid, name: [table]})
    assert getattr(scene, f"{name}s")[0].kind == kind


@pytest.mark.parametrize(("name", "kind", "dimension"), kinds())
def test_every_handle_follows_the_mouse(name, kind, dimension):
    grid = grid_of(dimension)
    plane = Plane.of(grid)
    table = edits.starting_table(name, kind, grid, plane)
    for handle in handles_of(name, table, grid, plane):
        to = np.array(handle.at) + 0.3 * grid.spacing
        changed = {**table, **drag_handle(name, table, handle, to, grid, plane)}
        again = [
            h for h in handles_of(name, changed, grid, plane)
            if (h.key, h.part) == (handle.key, handle.part)
        ]  # fmt: skip
        if handle.kind in ("point", "points"):
            np.testing.assert_allclose(again[0].at, to, atol=1e-8)
        else:
            assert changed != table


@pytest.mark.parametrize(
    "name", [name for name in builtin_names() if load_scene(name).grid.dimension == 2]
)
def test_four_quarter_turns_and_two_mirrors_change_nothing(name):
    scene, text = load_scene(name), edits.paste("[grid]\nshape = [400, 400]\n", {})[0]
    grid = scene.grid
    side = max(grid.shape)
    tables = tables_of(_squared(name, side))
    text = _squared(name, side)
    places = [(k, i) for k in ("light", "occluder") for i in range(len(tables.get(k, [])))]
    square = Grid((side, side))
    middle = np.full(2, side / 2)
    for matrix, count in (
        (edits.turn_matrix(1, FLAT, 2), 4),
        (edits.mirror_matrix(0, FLAT, 2), 2),
        (edits.mirror_matrix(1, FLAT, 2), 2),
    ):
        turned = text
        for _ in range(count):
            turned = edits.transform(turned, places, matrix, middle, square)
        first, last = Scene.from_dict(tables_of(text)), Scene.from_dict(tables_of(turned))
        for before, after in zip(first.walls(), last.walls()):
            ends = sorted(map(tuple, np.round([before.start, before.stop], 6).tolist()))
            assert sorted(map(tuple, np.round([after.start, after.stop], 6).tolist())) == ends
        for before, after in zip(first.lights, last.lights):
            assert after.kind == before.kind


def _squared(name, side):
    from flatland.scene import builtin_text
    from gui.models.toml_text import update_table

    return update_table(builtin_text(name), ("grid",), {"shape": [side, side]})


def test_a_mirrored_light_shines_to_the_mirrored_side():
    text = (
        "[grid]\nshape = [8, 8]\n"
        '[[light]]\nkind = "area"\nstart = [2, 1]\nend = [6, 3]\nflux = 1.0\n'
    )
    grid = Grid((8, 8))
    before = Scene.from_dict(tables_of(text)).lights[0].normal
    matrix = edits.mirror_matrix(0, FLAT, 2)
    mirrored = edits.transform(text, [("light", 0)], matrix, np.array([4.0, 4.0]), grid)
    after = Scene.from_dict(tables_of(mirrored)).lights[0].normal
    np.testing.assert_allclose(after, matrix @ before, atol=1e-12)


def test_a_line_of_cells_has_no_holes():
    cells = line((0, 0), (7, -3))
    steps = np.abs(np.diff(cells, axis=0)).max(axis=1)
    assert cells[-1] == (7, -3)
    assert steps.max() == 1


def test_a_fast_stroke_paints_every_cell_once():
    path = [(1.1, -1.9), (6.9, -1.9), (6.9, 2.9), (1.1, -1.9)]
    cells = cells_along(path, GRID, FLAT)
    assert len(cells) == len(set(cells))
    steps = np.abs(np.diff(np.array(cells), axis=0)).max(axis=1)
    assert np.count_nonzero(steps > 1) <= 1  # only where the path comes back to painted cells
    assert {(0, 0), (11, 0), (11, 9)} <= set(cells)


def test_strokes_outside_of_the_grid_paint_nothing():
    assert cells_along([(-5.0, -5.0), (-4.0, -4.0)], GRID, FLAT) == []


@pytest.mark.parametrize("kind", ["segment", "polygon", "circle"])
def test_a_stroke_makes_a_valid_occluder(kind):
    brush = Brush(kind={"light": "cell", "occluder": kind}, keys={"light": {}, "occluder": {}})
    path = [(1.5, -1.5), (2.0, 0.0), (3.0, 1.0)]
    tables = stroke_tables("occluder", brush, path, GRID, FLAT)
    scene = Scene.from_dict({"grid": GRID, "occluder": tables})
    assert scene.occluders[0].kind == kind
    assert stroke_tables("occluder", brush, path[:1] * 2, GRID, FLAT) == []


def test_in_3d_a_stroke_makes_a_box_one_layer_thick():
    plane = Plane.of(SOLID, 1, 3)
    tables = stroke_tables("occluder", Brush(), [(1.0, 1.0), (4.0, 3.0)], SOLID, plane)
    assert tables == [{"kind": "box", "min": [1.0, 3.0, 1.0], "max": [4.0, 4.0, 3.0]}]


def test_snapping_and_constraint():
    assert snapped((1.3, -1.6), GRID, FLAT) == pytest.approx((1.25, -1.5))
    x, y = constrained((0.0, 0.0), (3.0, 2.6))
    assert x == pytest.approx(y)
    assert math.hypot(x, y) == pytest.approx(math.hypot(3.0, 2.6))


def test_picking_up_takes_strength_but_not_place():
    brush = Brush()
    brush.take("light", {"kind": "area", "start": [0, 0], "end": [1, 0], "radiance": 2.0})
    assert (brush.kind["light"], brush.keys["light"]) == ("area", {"radiance": 2.0})
    brush.take("light", {"kind": "wall", "side": "left", "flux": 1.0})
    assert brush.kind["light"] == "area"


def test_distance_is_zero_inside_of_closed_items():
    circle = outline_of("occluder", {"kind": "circle", "center": [3, 0], "radius": 1}, GRID, FLAT)
    assert distance_to(circle, (3.2, 0.1)) == 0
    assert distance_to(circle, (5.0, 0.0)) == pytest.approx(1.0, abs=0.01)


def test_slices_know_their_axes():
    for normal, axes in ((0, (1, 2)), (1, (0, 2)), (2, (0, 1))):
        plane = Plane.of(SOLID, normal, 99)
        assert (plane.axes, plane.layer) == (axes, SOLID.shape[normal] - 1)
        values = np.arange(SOLID.cell_count).reshape(SOLID.shape)
        cut = plane.cut(values, 3)
        assert cut.shape == plane.shape(SOLID)
        assert cut[1, 2] == values[plane.cell(1, 2, 3)]


def test_zooming_keeps_the_place_under_the_mouse():
    camera = Camera()
    camera.fit((32, 32), 640, 480)
    before = camera.zoom
    around, seen = (5.0, 7.0), []
    camera.changed.connect(lambda: seen.append(camera.zoom))
    offset = (around[0] - camera.centre[0]) * camera.zoom
    camera.zoom_by(3, around)
    assert (around[0] - camera.centre[0]) * camera.zoom == pytest.approx(offset)
    assert camera.zoom > before
    assert not camera.fitted
    for _ in range(100):
        camera.zoom_by(1, around)
    assert camera.zoom == 1024


def test_every_field_of_every_kind_has_a_meaning():
    for name, registry in REGISTRIES.items():
        for kind in registry:
            for spec in specs_of_kind(name, kind):
                assert spec.meaning, (kind, spec.key)


def test_curves_as_csv():
    track = Track("lpv")
    track.add([Row(0, {"emitted": 1.0}), Row(1, {"emitted": 1.0, "left": 0.25})])
    track.add([Row(1, {"coefficients": 0.5})])
    rows = [line.split(",") for line in tracks_to_csv([track]).splitlines()]
    assert rows[0][:4] == ["run", "iteration", "emitted", "left"]
    assert rows[2][:4] == ["lpv", "1", "1.0", "0.25"]
    assert rows[2][rows[0].index("coefficients")] == "0.5"
