"""Grid sweeps against exact beams with the same ordinates."""

from __future__ import annotations

import numpy as np
from conftest import best_seconds

import propagators
from flatland import Scene, load_scene

_COUNT, _BANDS = 64, 4


def _scenes() -> dict[str, Scene]:
    light = {"kind": "area", "start": [24.0, 4.0], "end": [44.0, 4.0], "flux": 5.0}
    empty = Scene.from_dict({"grid": {"shape": [128, 128]}, "light": [light]})
    return {"128² empty": empty, "64² clutter": load_scene("clutter")}


def test_sweeps_against_beams(report):
    for name, scene in _scenes().items():
        exact = propagators.create("analytic").solve(scene, _BANDS).values
        beam = propagators.create("beam", ordinates=_COUNT)
        limit = best_seconds(lambda s=scene, b=beam: b.solve(s, _BANDS), 5)
        for rule in ("step", "diamond", "step-characteristics", "nodal"):
            sweeps = propagators.create("sn", rule=rule, ordinates=_COUNT)
            seconds = best_seconds(lambda s=scene, p=sweeps: p.solve(s, _BANDS), 5)
            values = sweeps.solve(scene, _BANDS).values
            error = np.linalg.norm(values - exact) / np.linalg.norm(exact)
            report(
                f"sn {rule}, {name}, {_COUNT} ordinates: error {error:.3f}, "
                f"{seconds * 1e3:.1f} ms, {seconds / limit:.1f} x beam"
            )
            # 4 % at the very least, what beams reach with a fraction of these ordinates.
            assert error > 0.02
