"""Light propagation maps against LPV's customary steps and against exact beams."""

from __future__ import annotations

import numpy as np
from conftest import best_seconds

import propagators
from flatland import Simulation, load_scene

_BANDS = 4


def test_maps_against_lpv_and_beams(report):
    for name in ("fig5-one-light", "shelf", "corridor"):
        scene = load_scene(name)
        exact = propagators.create("analytic").solve(scene, _BANDS).values
        schemes = {
            "maps": propagators.create("light-propagation-maps"),
            "beam": propagators.create("beam"),
        }
        seconds, errors = {}, {}
        for label, scheme in schemes.items():
            seconds[label] = best_seconds(lambda s=scheme, c=scene: s.solve(c, _BANDS), 5)
            values = scheme.solve(scene, _BANDS).values
            errors[label] = np.linalg.norm(values - exact) / np.linalg.norm(exact)

        def run(scene=scene) -> None:  # type: ignore[no-untyped-def]
            simulation = Simulation(scene, propagators.create("lpv"), bands=_BANDS)
            simulation.run(2 * max(scene.grid.shape))

        lpv = best_seconds(run, 5)
        report(
            f"{name}: maps error {errors['maps']:.4f}, beam {errors['beam']:.4f}; time of maps "
            f"{seconds['maps'] / seconds['beam']:.1f} x beam, {seconds['maps'] / lpv:.1f} x LPV"
        )
        assert errors["maps"] < 0.1
