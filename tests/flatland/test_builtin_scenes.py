"""Scenes that come with the package: whole, as they were meant, and the same after TOML."""

import numpy as np
import pytest

from flatland.harmonics import basis_for
from flatland.injection import inject
from flatland.injectors import AreaLight
from flatland.occlusion import without_first_bounces
from flatland.scene import builtin_names, builtin_text, load_scene, parse_scene, scene_to_toml


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
