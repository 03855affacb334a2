"""A mirrored or rotated scene injects a mirrored or rotated field."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatland.harmonics import CircularHarmonics
from flatland.injection import inject
from flatland.scene import Scene

WIDTH, HEIGHT, SPACING = 9, 7, 0.5
BASIS = CircularHarmonics(6)
#: Rounding of positions up to 10 cells, over the length of lights of a quarter cell and more.
TOLERANCE = 1e-12

#: Positions in cells, one cell away from the border: on borders, on halves, and anywhere.
inside = st.one_of(
    st.integers(4, 24).map(lambda quarter: quarter / 4),
    st.integers(0, 10**6).map(lambda part: 1 + 5 * part / 10**6),
)
part = st.integers(-1000, 1000).map(lambda n: n / 100)
area = st.fixed_dictionaries(
    {"kind": st.just("area"), "start": st.tuples(inside, inside), "end": st.tuples(inside, inside)}
).filter(lambda light: np.hypot(*np.subtract(light["end"], light["start"])) > 0.25)
cell = st.fixed_dictionaries(
    {
        "kind": st.just("cell"),
        "cell": st.tuples(st.integers(0, WIDTH - 1), st.integers(0, HEIGHT - 1)),
        "direction": st.tuples(part, part).filter(any),
    }
)
wall = st.fixed_dictionaries(
    {
        "kind": st.just("wall"),
        "side": st.sampled_from(["left", "right", "bottom", "top"]),
        "first": st.integers(0, 2),
        "last": st.integers(3, 6),
    }
)
lights = st.lists(st.one_of(area, cell, wall), min_size=1, max_size=4)
quick = settings(deadline=None, derandomize=True, max_examples=60)


def field_of(shape, lights):
    scaled = [dict(light, flux=1.0 + i) for i, light in enumerate(lights)]
    for light in scaled:
        for key in {"start", "end"} & set(light):
            light[key] = [SPACING * x for x in light[key]]
    scene = Scene.from_dict({"grid": {"shape": shape, "spacing": SPACING}, "light": scaled})
    return inject(scene, BASIS).values


def mirrored(light):
    """The light with x turned round."""
    match light["kind"]:
        case "area":  # ends swap, so that the front stays in front
            flip = [(WIDTH - light[key][0], light[key][1]) for key in ("end", "start")]
            return {"kind": "area", "start": flip[0], "end": flip[1]}
        case "cell":
            (i, j), (x, y) = light["cell"], light["direction"]
            return {"kind": "cell", "cell": (WIDTH - 1 - i, j), "direction": (-x, y)}
    if light["side"] in ("left", "right"):
        other = {"left": "right", "right": "left"}[light["side"]]
        return {**light, "side": other}
    return {**light, "first": WIDTH - 1 - light["last"], "last": WIDTH - 1 - light["first"]}


def rotated(light):
    """The light turned left by a quarter: (x, y) to (HEIGHT - y, x)."""
    match light["kind"]:
        case "area":
            start, end = ((HEIGHT - y, x) for x, y in (light["start"], light["end"]))
            return {"kind": "area", "start": start, "end": end}
        case "cell":
            (i, j), (x, y) = light["cell"], light["direction"]
            return {"kind": "cell", "cell": (HEIGHT - 1 - j, i), "direction": (-y, x)}
    turned = {"left": "bottom", "bottom": "right", "right": "top", "top": "left"}[light["side"]]
    if light["side"] in ("bottom", "top"):
        return {**light, "side": turned}
    first, last = HEIGHT - 1 - light["last"], HEIGHT - 1 - light["first"]
    return {**light, "side": turned, "first": first, "last": last}


@quick
@given(lights)
def test_mirrored_scene_gives_the_mirrored_field(lights):
    field = field_of((WIDTH, HEIGHT), lights)
    m = BASIS.degrees
    is_sine = (np.arange(BASIS.size) % 2 == 0) & (m > 0)
    parity = (-1.0) ** (m + is_sine)  # θ becomes π - θ
    expected = parity[:, None, None] * field[:, ::-1]
    found = field_of((WIDTH, HEIGHT), [mirrored(light) for light in lights])
    np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE)


@quick
@given(lights)
def test_rotated_scene_gives_the_rotated_field(lights):
    field = field_of((WIDTH, HEIGHT), lights)
    turned = field.transpose(0, 2, 1)[:, ::-1].copy()
    m = np.arange(1, BASIS.bands)[:, None, None]
    cosine, sine = turned[1::2].copy(), turned[2::2].copy()  # θ becomes θ + π/2
    c, s = np.cos(m * np.pi / 2), np.sin(m * np.pi / 2)
    turned[1::2], turned[2::2] = c * cosine - s * sine, s * cosine + c * sine
    found = field_of((HEIGHT, WIDTH), [rotated(light) for light in lights])
    np.testing.assert_allclose(found, turned, rtol=0, atol=TOLERANCE)


@pytest.mark.parametrize("name", ["fig5-l-shape", "two-walls"])
def test_symmetric_scene_gives_a_symmetric_flux(name):
    from flatland.scene import load_scene

    flux = inject(load_scene(name), BASIS).scalar_flux()
    image = flux.T if name == "fig5-l-shape" else flux[::-1]
    np.testing.assert_allclose(flux, image, rtol=0, atol=TOLERANCE)
