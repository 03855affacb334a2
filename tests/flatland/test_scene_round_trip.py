"""Any scene is the same after TOML."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flatland.scene import Scene, parse_scene, scene_to_toml

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
