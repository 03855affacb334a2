"""The exact reference on a cluttered grid."""

from __future__ import annotations

import propagators
from flatland import load_scene
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
