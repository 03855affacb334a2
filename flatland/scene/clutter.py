"""A scene full of random walls, of any size."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.scene.problems import scene_error, suggestion

Array = NDArray[np.float64]

#: Parameter: default, least, most.
PARAMETERS = {"size": (64, 16, 2**16), "occluders": (50, 0, 100_000), "seed": (7, 0, 2**32 - 1)}
#: Start and end of the slanted lights as parts of the size; they face each other.
LIGHTS = np.array([[[0.125, 0.25], [0.25, 0.1]], [[0.875, 0.75], [0.75, 0.9]]])
#: Clearance between walls and lights as a part of the size.
CLEARANCE = 1 / 32


def clutter_text(**parameters: Any) -> str:
    """TOML of `occluders` random walls and two slanted lights in size x size cells.

    The same seed gives the same layout at every size, scaled. Centres are uniform, up to 2/64
    of the size from the border, directions uniform, lengths uniform from 1/32 to 1/8 of the
    size; a wall that would come close to a light is drawn again. With 50 walls a ray runs
    0.4 of the size, on average, before it meets one (π area / (2 total length)).
    Raises SceneError for unknown or unfit parameters.
    """
    size, occluders, seed = _checked(parameters)
    lights = LIGHTS * size
    walls = _walls(size, occluders, np.random.default_rng(seed))
    parts = [_HEADER.format(size=size, occluders=occluders, seed=seed)]
    parts += [f'[[light]]\nkind = "area"\n{_ends(light)}radiance = 1.0\n' for light in lights]
    parts += [f'[[occluder]]\nkind = "segment"\n{_ends(wall)}' for wall in walls]
    return "\n".join(parts)


_HEADER = """\
# Random walls between two slanted lights that face each other: many shadow edges at all angles.
# Made by this project, as clutter:size={size},occluders={occluders},seed={seed}.

title = "Clutter: {occluders} random walls, seed {seed}"

[grid]
shape = [{size}, {size}]
"""


def _checked(parameters: dict[str, Any]) -> tuple[int, int, int]:
    for name, value in parameters.items():
        if name not in PARAMETERS:
            rule = f"is unknown{suggestion(name, list(PARAMETERS))}; accepted: "
            raise scene_error(name, rule + ", ".join(PARAMETERS), "clutter", "parameter")
        _, least, most = PARAMETERS[name]
        text = str(value)
        if not (text.isdecimal() and len(text) < 12 and least <= int(text) <= most):
            rule = f"must be a whole number from {least} to {most}"
            raise scene_error(value, rule, "clutter", name)
    size, occluders, seed = (
        int(parameters.get(name, default)) for name, (default, _, _) in PARAMETERS.items()
    )
    return size, occluders, seed


def _walls(size: int, count: int, generator: np.random.Generator) -> list[Array]:
    """Walls (2, 2) that keep their distance from the lights."""
    walls: list[Array] = []
    while len(walls) < count:
        x, y, turn, stretch = generator.random(4)
        angle, length = np.pi * turn, (0.5 + 1.5 * stretch) / 16
        half = 0.5 * length * np.array([np.cos(angle), np.sin(angle)])
        center = (2 + 60 * np.array([x, y])) / 64
        wall = np.array([center - half, center + half])
        if all(_distance(wall, light) > CLEARANCE for light in LIGHTS):
            walls.append(size * wall)
    return walls


def _distance(one: Array, other: Array) -> float:
    """Distance between two segments (2, 2)."""
    if _apart(one, other) or _apart(other, one):
        pairs = [(p, other) for p in one] + [(p, one) for p in other]
        return min(_point_distance(point, segment) for point, segment in pairs)
    return 0.0


def _apart(one: Array, other: Array) -> bool:
    """Whether both ends of `other` lie on the same side of the line through `one`."""
    (dx, dy), offsets = one[1] - one[0], other - one[0]
    sides = dx * offsets[:, 1] - dy * offsets[:, 0]
    return bool(sides[0] * sides[1] > 0)


def _point_distance(point: Array, segment: Array) -> float:
    along = segment[1] - segment[0]
    t = np.clip((point - segment[0]) @ along / (along @ along), 0.0, 1.0)
    return float(np.linalg.norm(segment[0] + t * along - point))


def _ends(segment: Array) -> str:
    start, end = ([round(float(x), 6) for x in point] for point in segment)
    return f"start = {start}\nend = {end}\n"
