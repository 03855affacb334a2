"""Modified discrete ordinates against its stencil alone and against exact beams."""

from __future__ import annotations

import numpy as np
from conftest import best_seconds

import propagators
from flatland import load_scene

_BANDS = 4
_SCHEMES = {
    "dom8": ("dom8", {}),
    "modified, dom8": ("modified-dom", {}),
    "modified, lpv": ("modified-dom", {"scheme": "lpv"}),
    "beam": ("beam", {}),
}


def test_modified_dom_against_its_parts(report):
    scene = load_scene("cornell-2d")
    exact = propagators.create("analytic").solve(scene, _BANDS).values
    errors = {}
    for label, (name, options) in _SCHEMES.items():
        scheme = propagators.create(name, **options)
        seconds = best_seconds(lambda s=scheme: s.solve(scene, _BANDS), 2)
        values = scheme.solve(scene, _BANDS).values
        errors[label] = np.linalg.norm(values - exact) / np.linalg.norm(exact)
        report(f"{label}, cornell-2d: error {errors[label]:.4f}, {seconds:.2f} s")
    assert errors["beam"] < errors["modified, dom8"] < errors["dom8"]
