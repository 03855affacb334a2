"""Scenes, light and schemes that are their own mirror image, and what tells halves from wholes."""

import itertools

import numpy as np

from flatland import Scene
from flatland.stencil import Stencil
from flatland.symmetry import image_offsets


def turned(values, basis, axis):
    """Light (size, *shape) turned round along an axis."""
    signs = basis.parities[:, axis].reshape(-1, *(1,) * (values.ndim - 1))
    return signs * np.flip(values, axis + 1)


def symmetric_light(rng, basis, shape, axes):
    """Random light (size, *shape) that is its own image along some axes, to the last bit."""
    values = rng.normal(size=(basis.size, *shape))
    for axis in axes:
        values = values + turned(values, basis, axis)
    return values


def symmetric_stencil(stencil, axes):
    """A scheme and its images, as one that is its own; clamped ones keep all faces of both."""
    for axis in axes:
        images = image_offsets(stencil, axis)
        signs = stencil.basis.parities[:, axis]
        other = (np.outer(signs, signs) * stencil.transfer)[images]
        if not stencil.clamp:
            stencil = Stencil(stencil.basis, stencil.offsets, (stencil.transfer + other) / 2)
            continue
        reception = np.concatenate([stencil.reception, (signs * stencil.reception)[images]], axis=1)
        emission = np.concatenate(
            [stencil.emission, (signs[:, None] * stencil.emission)[images]], axis=2
        )
        stencil = Stencil.from_faces(
            stencil.basis, stencil.offsets, reception, emission / 2, clamp=True
        )
    return stencil


def symmetric_shares(rng, stencil, shape, axes):
    """Random τ (K, *shape) that is its own image along some axes; a half of it is 1."""
    tau = rng.uniform(size=(len(stencil.offsets), *shape))
    tau[tau > 0.5] = 1.0
    for axis in axes:
        tau = np.maximum(tau, np.flip(tau[image_offsets(stencil, axis)], axis + 1))
    return tau


def images_of(point, shape, axes):
    """A point [cells] and its images along some axes, each once."""
    ends = [
        {x, float(n - x)} if axis in axes else {x}
        for axis, (x, n) in enumerate(zip(map(float, point), shape))
    ]
    return [list(place) for place in itertools.product(*map(sorted, ends))]


def lights(cell, shape, axes, **keys):
    """Cell lights in a cell and its images; `direction` is turned with them."""
    found = []
    for place in images_of(np.array(cell) + 0.5, shape, axes):
        more = dict(keys)
        if "direction" in more:
            signs = np.where(np.array(place) == np.array(cell) + 0.5, 1.0, -1.0)
            more["direction"] = (signs * more["direction"]).tolist()
        light = {"kind": "cell", "cell": np.floor(place).astype(int).tolist(), "flux": 1.0}
        found.append({**light, **more})
    return found


def walls(shape, axes, albedo=0.6):
    """A slanted segment, or a box, near the middle, and its images."""
    middle = np.array(shape) / 2
    if len(shape) == 2:
        ends = middle + np.array([[1.25, 3.5], [4.75, 0.5]])
        pairs = zip(*(images_of(end, shape, axes) for end in ends))
        return [
            {"kind": "segment", "start": start, "end": end, "albedo": albedo}
            for start, end in pairs
        ]
    corners = [
        images_of(middle + end, shape, axes) for end in ([1.25, 1.25, 1.25], [2.5, 1.75, 3.5])
    ]
    return [
        {
            "kind": "box",
            "min": np.minimum(first, second).tolist(),
            "max": np.maximum(first, second).tolist(),
            "albedo": albedo,
        }
        for first, second in zip(*corners)
    ]


def scene_of(shape, axes, light=None, with_walls=True, **tables):
    """A scene that is its own image along some axes and no others."""
    cell = [n // 2 - 2 - axis for axis, n in enumerate(shape)]
    light = lights(cell, shape, axes) if light is None else light
    occluders = walls(shape, axes) if with_walls else []
    return Scene.from_dict(
        {"grid": {"shape": list(shape)}, "light": light, "occluder": occluders, **tables}
    )
