"""Scenes that must have the same answer as the one of `analytic_scenes`, but for a known change."""

import numpy as np
from analytic_scenes import LIGHTS, WALLS, make_scene


def between(a, b, share):
    return tuple((1 - share) * np.array(a) + share * np.array(b))


def _cut_walls():
    halves = [(a, between(a, b, 0.3)) for a, b in WALLS]
    return make_scene(walls=halves + [(between(a, b, 0.3), b) for a, b in WALLS])


def _cut_lights():
    halves = [(a, between(a, b, 0.4), 0.4 * flux) for a, b, flux in LIGHTS]
    return make_scene(lights=halves + [(between(a, b, 0.4), b, 0.6 * f) for a, b, f in LIGHTS])


def _cut_crossing():
    (a, b), (c, d), *others = WALLS
    matrix = np.array([np.subtract(b, a), np.subtract(c, d)]).T
    meeting = between(a, b, np.linalg.solve(matrix, np.subtract(c, a))[0])
    return make_scene(walls=[(a, meeting), (meeting, b), (c, meeting), (meeting, d), *others])


def _flip(point):
    return 8 - point[0], point[1]


def _turn(point):
    return 8 - point[1], point[0]


#: The same scene, described in another way.
SAME = {
    "walls cut in two": _cut_walls,
    "lights cut in two": _cut_lights,
    "crossing walls cut at their crossing": _cut_crossing,
    "walls from end to start": lambda: make_scene(walls=[(b, a) for a, b in WALLS]),
    "walls twice and in another order": lambda: make_scene(walls=[*WALLS[::-1], *WALLS]),
    "other units": lambda: make_scene(spacing=0.1),
}


def mirrored_scene():
    # A mirror swaps left and right: a light's ends change places.
    return make_scene(
        lights=[(_flip(b), _flip(a), flux) for a, b, flux in LIGHTS],
        walls=[(_flip(a), _flip(b)) for a, b in WALLS],
    )


def mirrored(values):
    """Coefficients (size, nx, ny) of the mirrored scene: θ -> π - θ."""
    m = (np.arange(len(values)) + 1) // 2
    sine = (np.arange(len(values)) % 2 == 0) & (m > 0)
    sign = np.where(sine, -1.0, 1.0) * (-1.0) ** m
    return sign[:, None, None] * values[:, ::-1]


def turned_scene():
    return make_scene(
        lights=[(_turn(a), _turn(b), flux) for a, b, flux in LIGHTS],
        walls=[(_turn(a), _turn(b)) for a, b in WALLS],
    )


def turned(values):
    """Coefficients of the scene turned by a right angle, counter-clockwise."""
    powers = 1j ** np.arange(1, len(values) // 2 + 1)
    harmonics = (values[1::2] + 1j * values[2::2]) * powers[:, None, None]
    result = values.copy()
    result[1::2], result[2::2] = harmonics.real, harmonics.imag
    return np.moveaxis(result[:, :, ::-1], 1, 2)
