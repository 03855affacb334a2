"""A mirrored or rotated scene of lamps and walls injects a mirrored or rotated field."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flatland.harmonics import CircularHarmonics
from flatland.injection import inject
from flatland.scene import Scene

WIDTH, HEIGHT, SPACING = 9, 7, 0.5
BASIS = CircularHarmonics(5)
#: Rounding of positions, over angles and widths of a thousandth and more.
TOLERANCE = 1e-11

#: Positions in cells: on borders, on halves, and anywhere.
across = st.one_of(
    st.integers(4, 24).map(lambda quarter: quarter / 4),
    st.integers(0, 10**4).map(lambda part: 1 + 5 * part / 10**4),
)
points = st.tuples(across, across)
part = st.integers(-1000, 1000).map(lambda n: n / 100)
lamps = st.one_of(
    st.fixed_dictionaries({"kind": st.just("point"), "position": points}),
    st.fixed_dictionaries(
        {"kind": st.just("directional"), "direction": st.tuples(part, part).filter(any)}
    ),
    st.just({"kind": "environment"}),
)
walls = st.lists(
    st.tuples(points, points).filter(lambda ends: np.hypot(*np.subtract(*ends)) > 0.25),
    min_size=1,
    max_size=5,
)
quick = settings(deadline=None, derandomize=True, max_examples=60)
STRENGTH = {"point": "flux", "directional": "irradiance", "environment": "radiance"}


def field_of(shape, lamp, ends):
    scaled = {**lamp, STRENGTH[lamp["kind"]]: 1.0}
    if "position" in lamp:
        scaled["position"] = [SPACING * x for x in lamp["position"]]
    occluders = [
        {
            "kind": "segment",
            "start": [SPACING * x for x in start],
            "end": [SPACING * x for x in end],
            # The same for all: of walls that lie on one another the first listed is lit.
            "albedo": 0.5,
        }
        for start, end in ends
    ]
    grid = {"shape": shape, "spacing": SPACING}
    return inject(
        Scene.from_dict({"grid": grid, "light": [scaled], "occluder": occluders}), BASIS
    ).values


def keep_off_walls(lamp, ends):
    """Lamps on the line of a wall see it from its end, or are refused."""
    if "position" in lamp:
        lines = np.array(ends)
        way, along = np.array(lamp["position"]) - lines[:, 0], lines[:, 1] - lines[:, 0]
        assume(np.abs(along[:, 0] * way[:, 1] - along[:, 1] * way[:, 0]).min() > 1e-3)


def moved(lamp, ends, point, direction):
    """Lamp and walls with every point and direction mapped."""
    image = dict(lamp)
    if "position" in lamp:
        image["position"] = point(*lamp["position"])
    if "direction" in lamp:
        image["direction"] = direction(*lamp["direction"])
    return image, [(point(*start), point(*stop)) for start, stop in ends]


@quick
@given(lamps, walls)
def test_mirrored_scene_gives_the_mirrored_field(lamp, ends):
    keep_off_walls(lamp, ends)
    m = BASIS.degrees
    is_sine = (np.arange(BASIS.size) % 2 == 0) & (m > 0)
    parity = (-1.0) ** (m + is_sine)  # θ becomes π - θ
    expected = parity[:, None, None] * field_of((WIDTH, HEIGHT), lamp, ends)[:, ::-1]
    image = moved(lamp, ends, lambda x, y: (WIDTH - x, y), lambda x, y: (-x, y))
    np.testing.assert_allclose(field_of((WIDTH, HEIGHT), *image), expected, rtol=0, atol=TOLERANCE)


@quick
@given(lamps, walls)
def test_rotated_scene_gives_the_rotated_field(lamp, ends):
    keep_off_walls(lamp, ends)
    turned = field_of((WIDTH, HEIGHT), lamp, ends).transpose(0, 2, 1)[:, ::-1].copy()
    m = np.arange(1, BASIS.bands)[:, None, None]
    cosine, sine = turned[1::2].copy(), turned[2::2].copy()  # θ becomes θ + π/2
    c, s = np.cos(m * np.pi / 2), np.sin(m * np.pi / 2)
    turned[1::2], turned[2::2] = c * cosine - s * sine, s * cosine + c * sine
    image = moved(lamp, ends, lambda x, y: (HEIGHT - y, x), lambda x, y: (-y, x))
    np.testing.assert_allclose(field_of((HEIGHT, WIDTH), *image), turned, rtol=0, atol=TOLERANCE)
