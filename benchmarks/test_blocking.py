"""Exact blocking: what is cut before a run, and what it costs in every step.

What is cut has no limit in the same run to be compared with: processor time is told, all threads
together, which other work on the machine disturbs least.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
import trimesh

import propagators
from flatland.blocking import exact_transmittance
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.kernels import Layout, Sweep
from flatland.sources import Facet, Segment

_BLACK = np.zeros(1)
_SPACE = Grid((64, 64, 64))
#: A step with τ over one without, for 64³ cells and 2 bands. τ is read where walls are near: in a
#: room with a box and a screen, next to one vector of cells in ten; among fourteen slanted screens,
#: two in three, and 26 shares a cell are six times what its light is.
_ALLOWED = {"box": 1.5, "room": 3.5}


def _links(dimension: int) -> np.ndarray:
    """All 8 or 26 neighbours."""
    name = {2: "dom8", 3: "dom26"}[dimension]
    return propagators.create(name).stencil(basis_for(dimension, 1)).offsets


def _room() -> list[Facet]:
    """Six walls and fourteen slanted rectangles of 10 to 60 cells."""
    generator = np.random.default_rng(1)
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    faces = [
        np.insert(28 * square + 32, axis, place, axis=1) for axis in range(3) for place in (4, 60)
    ]
    for _ in range(14):
        axes = np.linalg.qr(generator.normal(size=(3, 3)))[0][:2]
        faces.append(square * generator.uniform(5, 30, 2) @ axes + 64 * generator.random(3))
    return [Facet(face, _BLACK) for face in faces]


def _box() -> list[Facet]:
    """A box and a screen."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    faces = [
        np.insert(8 * square + 38, axis, 38.0 + side, axis=1)
        for axis in range(3)
        for side in (-8, 8)
    ]
    return [Facet(face, _BLACK) for face in [*faces, np.insert(16 * square + 22, 1, 45.0, axis=1)]]


def _ball(subdivisions: int) -> list[Facet]:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return [Facet(25 * face + 32.2, _BLACK) for face in np.asarray(mesh.triangles)]


def _processor_seconds(call: Callable[[], object], repeats: int) -> float:
    """Least of one call, after one that is not counted."""
    call()
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


@pytest.mark.parametrize("count", [100, 1000])
@pytest.mark.parametrize("length", [4.0, 40.0])
def test_segments_in_256_cells_squared(count, length, report):
    generator, grid = np.random.default_rng(0), Grid((256, 256))
    middles, angles = 256 * generator.random((count, 2)), np.pi * generator.random(count)
    halves = 0.5 * length * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    walls = [Segment(m - h, m + h, _BLACK) for m, h in zip(middles, halves)]
    seconds = _processor_seconds(lambda: exact_transmittance(grid, walls, _links(2)), 5)
    report(f"τ of {count} segments of {length:g} cells, 256², 8 neighbours: {seconds:.3f} s")
    assert seconds < 1.0


@pytest.mark.parametrize(
    ("name", "facets", "allowed"),
    [("room of 20 quads", _room(), 3.0), ("ball of 20,480 triangles", _ball(5), 8.0)],
)
def test_facets_in_64_cells_cubed(name, facets, allowed, report):
    seconds = _processor_seconds(lambda: exact_transmittance(_SPACE, facets, _links(3)), 3)
    report(f"τ of a {name}, 64³, 26 neighbours: {seconds:.2f} s")
    assert seconds < allowed


@pytest.mark.parametrize(("scene", "walls"), [("box", _box()), ("room", _room())])
@pytest.mark.parametrize("name", ["lpv", "dom6", "dom26"])
def test_a_step_among_walls_against_one_without(name, scene, walls, report):
    stencil = propagators.create(name).stencil(basis_for(3, 2))
    layout = Layout(_SPACE.shape, 4, np.dtype(np.float32))
    tau = exact_transmittance(_SPACE, walls, stencil.offsets)
    source, target, total = (layout.allocate() for _ in range(3))
    layout.view(source)[...] = np.random.default_rng(1).random(layout.view(source).shape)
    plain, blocked = (
        _processor_seconds(lambda s=sweep: s.steps(source, target, total, 16), 20)
        for sweep in (Sweep(stencil, layout), Sweep(stencil, layout, tau))
    )
    report(
        f"{name} 2 bands, 64³, {scene}, float32: walls make a step {blocked / plain:.2f} x as long"
    )
    assert blocked <= _ALLOWED[scene] * plain
