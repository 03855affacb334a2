"""The exact reference on a cluttered grid, and in a room."""

from __future__ import annotations

import time

import numpy as np

import propagators
from flatland import Scene, load_scene
from studies.bench.limits import best_seconds


def test_reference_with_50_occluders(report):
    scene = load_scene("clutter:size=64,occluders=50")
    analytic = propagators.create("analytic")
    seconds = {bands: best_seconds(lambda n=bands: analytic.solve(scene, n), 3) for bands in (4, 8)}
    report(
        "analytic 64², 50 occluders: "
        + ", ".join(f"{n} bands {t:.2f} s" for n, t in seconds.items())
    )
    assert max(seconds.values()) < 2.0


def test_reference_with_1000_walls(report):
    """256² cells, black walls of 4 to 40 cells all over; 30 s on two cores at most."""
    scene, analytic = _walls(1000, 256), propagators.create("analytic")
    seconds = {bands: best_seconds(lambda n=bands: analytic.solve(scene, n), 2) for bands in (2, 5)}
    told = ", ".join(f"{n} bands {t:.2f} s" for n, t in seconds.items())
    report(f"analytic 256², 1,000 walls: {told}")
    assert max(seconds.values()) < 30.0


def _walls(count: int, side: int) -> Scene:
    generator = np.random.default_rng(0)
    middles, angles = side * generator.random((count, 2)), np.pi * generator.random(count)
    halves = 0.5 * generator.uniform(4, 40, count)[:, None]
    halves = halves * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    occluders = [
        {"kind": "segment", "albedo": 0.0, "start": start.tolist(), "end": end.tolist()}
        for start, end in zip(middles - halves, middles + halves)
    ]
    light = {"kind": "area", "start": [0.3 * side, 1.0], "end": [0.6 * side, 1.0], "flux": 5.0}
    return Scene.from_dict(
        {"grid": {"shape": [side, side]}, "light": [light], "occluder": occluders}
    )


def test_reference_of_the_cornell_box(report):
    """On two cores, 120 s at most."""
    room, reference = load_scene("cornell-3d"), propagators.create("analytic")
    direct = propagators.create("analytic", bounces=False)
    seconds = {
        "direct": best_seconds(lambda: direct.solve(room, 3), 1),
        "with bounces": best_seconds(lambda: reference.solve(room, 3), 1),
        "books": best_seconds(lambda: reference.energy(room), 1),
        "256 directions": best_seconds(lambda: reference.intensity(room, _directions(256)), 1),
    }
    told = ", ".join(f"{name} {t:.1f} s" for name, t in seconds.items())
    report(f"analytic, cornell-3d, 16³, 3 bands: {told}")
    assert seconds["with bounces"] < 120


def test_reference_of_the_cornell_box_by_tolerance(report):
    """Processor time, which neighbours on the machine stretch less than time."""
    room, lines = load_scene("cornell-3d"), []
    for tolerance in (3e-3, 1e-3, 5e-4):
        start = time.process_time()
        propagators.create("analytic", tolerance=tolerance).solve(room, 3)
        lines.append(f"{tolerance:g}: {time.process_time() - start:.1f} s")
    report("analytic, cornell-3d, processor time by tolerance: " + ", ".join(lines))


def _directions(count):
    vectors = np.random.default_rng(1).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
