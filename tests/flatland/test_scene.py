"""Scenes: by name, from text, from Python, and back to text."""

import pickle
import re

import numpy as np
import pytest
import trimesh

from flatland.errors import InputError
from flatland.grid import Grid
from flatland.injectors import INJECTORS, AreaLight
from flatland.occluders import OCCLUDERS, SegmentOccluder
from flatland.scene import Scene, load_scene, parse_scene, scene_template, scene_to_toml
from flatland.sources import PointSource, SegmentSource

SMALLEST = """
title = "One area light"

[grid]
shape = [17, 17]        # cells along x, y[, z]
spacing = 1.0

[[light]]
kind = "area"
start = [6.0, 1]
end = [11.0, 1.0]
flux = [5.0, 1, 0.5]

[[occluder]]
kind = "segment"
start = [3.0, 8.0]
end = [9.0, 80.0]
albedo = 0.25
"""


def test_tables_become_grid_lights_and_occluders():
    scene = parse_scene(SMALLEST)
    assert scene.title == "One area light"
    assert scene.grid == Grid((17, 17))
    assert scene.lights == (AreaLight(start=(6.0, 1.0), end=(11.0, 1.0), flux=(5.0, 1.0, 0.5)),)
    assert scene.occluders == (SegmentOccluder(start=(3.0, 8.0), end=(9.0, 80.0), albedo=0.25),)


@pytest.mark.parametrize(
    ("flux", "albedo", "colours"),
    [(1, 0.5, 0), ([1], 0.5, 1), (1, [0.1, 0.2], 2), ([1, 2], [0, 1], 2)],
)
def test_number_of_colours_is_that_of_the_lists(flux, albedo, colours):
    scene = Scene.from_dict(
        {
            "grid": {"shape": [4, 4]},
            "light": [{"kind": "cell", "cell": [1, 1], "flux": flux}],
            "occluder": [{"kind": "segment", "start": [0, 0], "end": [1, 0], "albedo": albedo}],
        }
    )
    assert scene.colours == colours
    assert scene.sources()[0].spectrum.shape == (max(1, colours),)
    assert scene.segments()[0].albedo.shape == (max(1, colours),)


def test_sources_and_segments_are_those_of_the_tables():
    scene = load_scene("corridor")
    (light,), walls = scene.sources(), scene.segments()
    assert isinstance(light, SegmentSource)
    np.testing.assert_array_equal([light.start, light.stop], [[2, 7], [2, 2]])
    assert len(walls) == 6


@pytest.mark.parametrize("dimension", [2, 3])
def test_template_loads(dimension):
    scene = parse_scene(scene_template(dimension))
    assert scene.grid.dimension == dimension
    assert scene.lights
    assert scene.walls()


def test_template_of_no_dimension_is_refused():
    with pytest.raises(InputError, match="dimension = 4: .*; accepted: 2, 3"):
        scene_template(4)


@pytest.mark.parametrize("dimension", [2, 3])
def test_every_example_in_the_template_loads(tmp_path, dimension):
    shape = parse_scene(scene_template(dimension)).grid.shape
    np.savez(tmp_path / "light.npz", coefficients=np.zeros((9, *shape)))
    trimesh.creation.box().export(tmp_path / "mesh.stl")
    text = re.sub(r"^# (?=\[|\w+ = )", "", scene_template(dimension), flags=re.MULTILINE)
    scene = parse_scene(text, directory=tmp_path)
    assert scene.medium is not None
    for items, registry in ((scene.lights, INJECTORS), (scene.occluders, OCCLUDERS)):
        kinds = {name for name, kind in registry.items() if dimension in kind.dimensions}
        assert {item.kind for item in items} == kinds


def test_file_is_found_by_path_and_names_its_data_from_its_own_folder(tmp_path):
    np.save(tmp_path / "light.npy", np.ones((1, 2, 2)))
    path = tmp_path / "scene.toml"
    path.write_text('[grid]\nshape = [2, 2]\n[[light]]\nkind = "file"\nfile = "light.npy"\n')
    assert load_scene(path) == load_scene(str(path))
    assert len(load_scene(path).sources()) == 4


def test_byte_order_mark_and_windows_line_ends_are_fine():
    text = SMALLEST.replace("\n", "\r\n")
    assert parse_scene(b"\xef\xbb\xbf" + text.encode()) == parse_scene(SMALLEST)


def test_python_values_may_stand_for_lists_and_tables():
    scene = Scene.from_dict(
        {
            "grid": Grid(np.array([17, 17])),
            "light": [AreaLight(start=(6.0, 1.0), end=(11.0, 1.0), flux=5.0)],
            "occluder": [
                {"kind": "segment", "start": np.array([3, 8]), "end": np.array([9.0, 8.0])}
            ],
        }
    )
    assert parse_scene(scene_to_toml(scene)) == scene


def test_scene_survives_pickling_and_hashing():
    scene = load_scene("shelf")
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert hash(parse_scene(scene_to_toml(scene))) == hash(scene)


def test_3d_grid_takes_the_kinds_that_know_3d():
    scene = parse_scene(
        '[grid]\nshape = [4, 4, 4]\norigin = [1, 2, 3]\n[[light]]\nkind = "cell"\n'
        "cell = [1, 2, 3]\nflux = 1\n"
    )
    (source,) = scene.sources()
    assert isinstance(source, PointSource)
    np.testing.assert_array_equal(source.position, [2.5, 4.5, 6.5])
