"""A scene file to start from, with an example of every kind of light and occluder."""

from __future__ import annotations

from flatland.errors import bad_input
from flatland.injectors import INJECTORS
from flatland.occluders import OCCLUDERS

_HEAD = {
    2: """\
# A scene: what is there. How it is computed is chosen when it is run.
# Lengths are in metres, fluxes in watts; x points right, y up.

title = "My scene"

[grid]
shape = [32, 32]        # cells along x, y
spacing = 1.0           # side of a cell
# origin = [0.0, 0.0]   # lower corner of the grid
""",
    3: """\
# A scene: what is there. How it is computed is chosen when it is run.
# Lengths are in metres, fluxes in watts; x points right, y up, z towards you.

title = "My scene"

[grid]
shape = [16, 16, 16]    # cells along x, y, z
spacing = 1.0           # side of a cell
# origin = [0.0, 0.0, 0.0]  # lower corner of the grid
""",
}

#: Examples by dimension and kind: the first of them is there to use, the others as comments.
_LIGHTS = {
    2: {
        "area": """\
# A segment that emits to the left of start -> end. On a cell border its light starts in the
# middle of the cell in front of it.
[[light]]
kind = "area"
start = [8.0, 2.0]
end = [24.0, 2.0]
flux = 16.0             # or radiance = ...; for colours a list: flux = [16.0, 8.0, 4.0]
""",
        "cell": """\
[[light]]
kind = "cell"
cell = [4, 20]        # counted from 0
direction = [1.0, 0.0]  # without it the light is the same in all directions
flux = 1.0
""",
        "wall": """\
[[light]]
kind = "wall"
side = "left"         # left, right, bottom, top
flux = 8.0            # of the whole side
first = 8             # part of the side, cells counted from 0
last = 23
""",
        "point": """\
[[light]]
kind = "point"        # shines in all directions, and off the walls
position = [4.5, 24.5]
flux = 4.0
inject = "both"       # or "direct", its own light, or "bounce", what walls send back
""",
        "directional": """\
[[light]]
kind = "directional"  # parallel light from outside, and what walls send back
direction = [1.0, -2.0]
irradiance = 0.5      # per metre across the light
""",
        "environment": """\
[[light]]
kind = "environment"  # the same from every direction outside
radiance = 0.1
""",
        "file": """\
[[light]]
kind = "file"
file = "light.npz"    # array "coefficients" of shape (2 n - 1, 32, 32) for n bands
multiplier = 1.0
""",
    },
    3: {
        "area": """\
# A flat polygon that emits to the side from which its vertices run counter-clockwise. On a cell
# border its light starts in the middle of the cell in front of it.
[[light]]
kind = "area"           # this one emits down
vertices = [[6.0, 15.0, 6.0], [10.0, 15.0, 6.0], [10.0, 15.0, 10.0], [6.0, 15.0, 10.0]]
flux = 16.0             # or radiance = ...; for colours a list: flux = [16.0, 8.0, 4.0]
""",
        "cell": """\
[[light]]
kind = "cell"
cell = [4, 10, 8]     # counted from 0
direction = [1.0, 0.0, 0.0]  # without it the light is the same in all directions
flux = 1.0
""",
        "wall": """\
[[light]]
kind = "wall"
side = "back"         # left, right, bottom, top, back (z = 0), front
flux = 8.0            # of the whole side
""",
        "point": """\
[[light]]
kind = "point"        # shines in all directions, and off the walls
position = [4.5, 12.5, 8.5]
flux = 4.0
inject = "both"       # or "direct", its own light, or "bounce", what walls send back
""",
        "directional": """\
[[light]]
kind = "directional"  # parallel light from outside, and what walls send back
direction = [1.0, -2.0, -0.5]
irradiance = 0.5      # per square metre across the light
""",
        "environment": """\
[[light]]
kind = "environment"  # the same from every direction outside
radiance = 0.1
""",
        "file": """\
[[light]]
kind = "file"
file = "light.npz"    # array "coefficients" of shape (n², 16, 16, 16) for n bands
multiplier = 1.0
""",
    },
}

_OCCLUDERS = {
    2: {
        "segment": """\
# A thin wall, opaque from both sides.
[[occluder]]
kind = "segment"
start = [4.0, 16.0]
end = [20.0, 16.0]
albedo = 0.0            # reflected share, 0 is black
""",
        "polygon": """\
[[occluder]]
kind = "polygon"
vertices = [[22.0, 18.0], [28.0, 18.0], [25.0, 24.0]]
""",
        "circle": """\
[[occluder]]
kind = "circle"
center = [10.0, 26.0]
radius = 3.0
""",
    },
    3: {
        "box": """\
# Six walls, opaque from both sides.
[[occluder]]
kind = "box"
min = [3.0, 0.0, 3.0]
max = [7.0, 8.0, 8.0]
albedo = 0.0            # reflected share, 0 is black
""",
        "quad": """\
[[occluder]]
kind = "quad"         # a thin flat wall; corners in order round its outline
vertices = [[8.0, 0.0, 12.0], [14.0, 0.0, 9.0], [14.0, 6.0, 9.0], [8.0, 6.0, 12.0]]
""",
        "mesh": """\
[[occluder]]
kind = "mesh"
file = "mesh.stl"     # a closed surface; .stl, .obj, .ply or .off
scale = 1.0           # metres per unit of the file
position = [8.0, 4.0, 8.0]  # of the file's origin
open = false          # true for thin walls, which need not close
""",
    },
}


def scene_template(dimension: int = 2) -> str:
    """A commented scene file to start from, in 2D or 3D; it loads as it is."""
    if dimension not in _HEAD:
        raise bad_input("dimension", dimension, "is no dimension of a grid", tuple(_HEAD))
    kinds = {**INJECTORS, **OCCLUDERS}
    lights, occluders = (
        [text for kind, text in examples.items() if dimension in kinds[kind].dimensions]
        for examples in (_LIGHTS[dimension], _OCCLUDERS[dimension])
    )
    more = "# More kinds of light; take the # away to use them.\n"
    parts = [_HEAD[dimension], lights[0], more + _commented(lights[1:])]
    return "\n".join([*parts, occluders[0], _commented(occluders[1:])])


def _commented(examples: list[str]) -> str:
    """Examples as comments, with an empty one between."""
    lines = "\n".join(examples).splitlines()
    return "".join(f"# {line}\n" if line else "#\n" for line in lines)
