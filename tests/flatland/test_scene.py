"""Scenes: by name, from text, from Python, and back to text."""

import pickle
import re

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from flatland.errors import InputError
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.injection import inject
from flatland.injectors import INJECTORS, AreaLight
from flatland.occluders import OCCLUDERS, SegmentOccluder
from flatland.occlusion import without_first_bounces
from flatland.scene import (
    Scene,
    builtin_names,
    builtin_text,
    load_scene,
    parse_scene,
    scene_template,
    scene_to_toml,
)
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


@pytest.mark.parametrize("name", builtin_names())
def test_every_builtin_scene_loads_and_says_where_it_comes_from(name):
    assert load_scene(name).title
    assert builtin_text(name).startswith("# ")


@pytest.mark.parametrize("name", builtin_names())
def test_every_builtin_scene_survives_toml(name):
    scene = load_scene(name)
    assert parse_scene(scene_to_toml(scene)) == scene


#: Built-in scenes whose surfaces reflect, in colours.
COLOURED = {"atrium", "cornell-2d", "cornell-3d", "point-lights-3d"}


@pytest.mark.parametrize("name", builtin_names())
def test_every_other_builtin_scene_is_black_and_grey(name):
    scene = load_scene(name)
    assert scene.colours == (3 if name in COLOURED else 0)
    assert any(wall.albedo.any() for wall in scene.walls()) == (name in COLOURED)


def area_lights(scene):
    return [light for light in scene.lights if isinstance(light, AreaLight)]


@pytest.mark.parametrize("name", [name for name in builtin_names() if name.endswith("-3d")])
def test_lights_of_a_scene_in_space_put_all_of_their_flux_into_cells(name):
    """Their own light: what lamps bounce is not counted."""
    scene = load_scene(name)
    assert scene.grid.dimension == 3
    flux = inject(without_first_bounces(scene), basis_for(3, 2)).total_flux()
    expected = sum(light.channels(scene.colours) for light in scene.lights)
    np.testing.assert_allclose(flux, expected if scene.colours else expected[0], rtol=1e-12)


@pytest.mark.parametrize("name", ["shelf", "two-walls", "fig5-one-light"])
def test_a_scene_in_space_has_the_lights_of_its_flat_twin(name):
    """As seen along z, for the directions that a flat scene knows."""
    flat, deep = load_scene(name), load_scene(f"{name}-3d")
    scale = deep.grid.shape[0] / flat.grid.shape[0]
    assert deep.grid.shape[1] == scale * flat.grid.shape[1]
    for one, other in zip(area_lights(flat), area_lights(deep), strict=True):
        np.testing.assert_allclose(other.normal, [*one.normal, 0], atol=1e-15)
        ends = scale * one.emitter.points
        np.testing.assert_allclose(np.unique(other.emitter.points[:, :2], axis=0), np.sort(ends, 0))
    walls = [scale * np.sort([wall.start, wall.stop], axis=0) for wall in flat.segments()]
    sides = [np.unique(wall.vertices[:, :2], axis=0) for wall in deep.facets()]
    np.testing.assert_allclose(np.reshape(walls, (-1, 2, 2)), np.reshape(sides, (-1, 2, 2)))


def test_walls_of_the_cornell_box_face_its_room():
    """Every ray from the light meets the front of a wall first, or leaves by the open side."""
    scene = load_scene("cornell-3d")
    generator = np.random.default_rng(4)
    directions = generator.normal(size=(200, 3))
    directions[:, 1] = -np.abs(directions[:, 1])
    start = scene.lights[0].emitter.points.mean(axis=0) - [0, 1e-6, 0]
    hits = np.array([first_hit(scene.facets(), start, ray) for ray in directions])
    assert set(hits) == {1, 0}
    assert np.all(directions[hits == 0, 2] > 0)


def first_hit(facets, start, ray):
    """1 if the first wall that a ray meets faces it, -1 if not, 0 if there is none."""
    nearest, side = np.inf, 0
    for facet in facets:
        corners = facet.vertices
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
        along = ray @ normal
        distance = (corners[0] - start) @ normal / along if along else np.inf
        place = start + min(distance, 1e9) * ray
        edges = np.roll(corners, -1, axis=0) - corners
        if 1e-9 < distance < nearest and np.all(np.cross(edges, place - corners) @ normal >= 0):
            nearest, side = distance, -np.sign(along)
    return int(side)


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
    text = re.sub(r"^# (?=\[\[|\w+ = )", "", scene_template(dimension), flags=re.MULTILINE)
    scene = parse_scene(text, directory=tmp_path)
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


def test_clutter_scales_with_its_size():
    small, large = (load_scene(f"clutter:size={size},occluders=9,seed=3") for size in (32, 128))
    for one, other in zip(small.segments(), large.segments()):
        np.testing.assert_allclose(4 * one.start, other.start, atol=1e-5)
        np.testing.assert_allclose(4 * one.stop, other.stop, atol=1e-5)


def test_clutter_depends_on_its_seed_alone():
    assert builtin_text("clutter:seed=3") == builtin_text("clutter:seed=3")
    assert builtin_text("clutter:seed=3") != builtin_text("clutter:seed=4")


def test_clutter_keeps_its_distance_from_the_lights():
    scene = load_scene("clutter:size=64,occluders=400")
    t = np.linspace(0, 1, 101)[:, None]
    lights, walls = (
        np.concatenate([(1 - t) * s.start + t * s.stop for s in segments])
        for segments in (scene.sources(), scene.segments())
    )
    distances = np.linalg.norm(lights[:, None] - walls, axis=-1)
    assert distances.min() > 64 / 32 - 1e-5


number = st.floats(-1e6, 1e6) | st.integers(-100, 100)
share = st.floats(0, 1)
inside = st.floats(1, 7) | st.integers(1, 7)
amount = st.floats(0, 1e9) | st.integers(0, 9)


def per_colour(value, colours):
    lists = st.lists(value, min_size=colours, max_size=colours)
    return value if colours == 0 else value | lists


def far_apart(table):
    return np.hypot(*np.subtract(table["end"], table["start"])) > 1e-3


@st.composite
def scenes(draw):
    """Tables of random valid scenes on a grid of 8 x 8 cells around an origin."""
    colours = draw(st.integers(0, 3))
    flux = per_colour(amount, colours)
    point, anywhere = st.tuples(inside, inside), st.tuples(number, number)
    optional = {"direction": st.tuples(number, number).filter(any)}
    kinds = st.one_of(
        st.fixed_dictionaries(
            {"kind": st.just("area"), "start": point, "end": point, "flux": flux}
        ).filter(far_apart),
        st.fixed_dictionaries(
            {"kind": st.just("area"), "start": point, "end": point, "radiance": flux}
        ).filter(far_apart),
        st.fixed_dictionaries(
            {"kind": st.just("cell"), "cell": st.tuples(*[st.integers(0, 7)] * 2), "flux": flux},
            optional=optional,
        ),
        st.fixed_dictionaries(
            {"kind": st.just("wall"), "side": st.sampled_from(["left", "top"]), "flux": flux},
            optional={"first": st.integers(0, 3), "last": st.integers(3, 7), **optional},
        ),
        st.fixed_dictionaries(
            {"kind": st.just("directional"), "irradiance": flux, **optional},
            optional={"inject": st.sampled_from(["bounce", "both"]), "texels": st.integers(1, 99)},
        ),
        st.fixed_dictionaries({"kind": st.just("environment"), "radiance": flux}),
    )
    albedo = {"albedo": per_colour(share, colours)}
    occluder = st.one_of(
        st.fixed_dictionaries(
            {"kind": st.just("segment"), "start": anywhere, "end": anywhere}, optional=albedo
        ).filter(far_apart),
        st.fixed_dictionaries(
            {"kind": st.just("circle"), "center": anywhere, "radius": st.floats(1, 1e6)},
            optional={"segments": st.integers(3, 20), **albedo},
        ),
    )
    return {
        "title": draw(st.text(st.characters(codec="utf-8"))),
        "grid": {"shape": [8, 8], "origin": [draw(st.floats(-1e-3, 1e-3)), 0]},
        "light": draw(st.lists(kinds, max_size=3)),
        "occluder": draw(st.lists(occluder, max_size=3)),
    }


@st.composite
def space_scenes(draw):
    """Tables of random valid scenes on a grid of 8 x 8 x 8 cells."""
    colours = draw(st.integers(0, 3))
    flux = per_colour(amount, colours)
    place, wide = st.tuples(*[inside] * 3), st.tuples(*[number] * 3)
    triangle = st.tuples(place, place, place).filter(lambda t: doubled_area(t) > 0.1)
    lights = st.one_of(
        st.fixed_dictionaries({"kind": st.just("area"), "vertices": triangle, "flux": flux}),
        st.fixed_dictionaries({"kind": st.just("area"), "vertices": triangle, "radiance": flux}),
        st.fixed_dictionaries(
            {"kind": st.just("wall"), "side": st.sampled_from(["back", "top"]), "flux": flux},
            optional={"direction": wide.filter(any)},
        ),
    )
    albedo = {"albedo": per_colour(share, colours)}
    quads = triangle.map(lambda t: [*t, np.add(t[0], np.subtract(t[2], t[1])).tolist()])
    occluders = st.one_of(
        st.fixed_dictionaries({"kind": st.just("quad"), "vertices": quads}, optional=albedo),
        st.builds(
            lambda low, size, keys: {
                "kind": "box",
                "min": low,
                "max": np.add(low, size).tolist(),
                **keys,
            },
            wide,
            st.tuples(*[st.floats(1, 1e3)] * 3),
            st.fixed_dictionaries({}, optional=albedo),
        ),
    )
    return {
        "grid": {"shape": [8, 8, 8], "spacing": draw(st.floats(1, 1.5))},
        "light": draw(st.lists(lights, max_size=3)),
        "occluder": draw(st.lists(occluders, max_size=3)),
    }


def doubled_area(triangle):
    a, b, c = np.array(triangle, float)
    return np.linalg.norm(np.cross(b - a, c - a))


@settings(deadline=None, derandomize=True, max_examples=80)
@given(scenes() | space_scenes())
def test_any_scene_survives_toml(tables):
    scene = Scene.from_dict(tables)
    assert parse_scene(scene_to_toml(scene)) == scene
