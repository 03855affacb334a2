"""Radiance cascades against exact beams of about the same error."""

from __future__ import annotations

import numpy as np
from conftest import best_seconds

import propagators
from flatland import load_scene

_BANDS = 4
_VARIANTS = {
    "vanilla": ("radiance-cascades", {"fix": "vanilla"}),
    "cheap": ("radiance-cascades", {"fix": "cheap"}),
    "bilinear": ("radiance-cascades", {}),
    "holographic": ("holographic-rc", {}),
    "holographic, cast": ("holographic-rc", {"rays": "cast"}),
}


def test_cascades_against_beams(report):
    scene = load_scene("clutter")
    exact = propagators.create("analytic").solve(scene, _BANDS).values

    def error(propagator: propagators.Propagator) -> float:
        values = propagator.solve(scene, _BANDS).values
        return float(np.linalg.norm(values - exact) / np.linalg.norm(exact))

    beam = propagators.create("beam", ordinates=64)
    limit, best = best_seconds(lambda: beam.solve(scene, _BANDS), 5), error(beam)
    report(f"beam, clutter 64², 64 ordinates: error {best:.3f}, {limit * 1e3:.1f} ms")
    for label, (name, options) in _VARIANTS.items():
        cascade = propagators.create(name, **options)
        seconds = best_seconds(lambda c=cascade: c.solve(scene, _BANDS), 2)
        found = error(cascade)
        report(f"{label}: error {found:.3f}, {seconds / limit:.0f} x beam")
        assert found < 0.25
