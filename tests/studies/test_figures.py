"""Figures: complete, and the same bytes from the same data."""

from __future__ import annotations

import numpy as np
import pytest

import propagators
from flatland import Scene, load_scene
from studies.comparison import compare
from studies.figures.comparison import LARGEST_FOR_LOBES, comparison_data, draw_comparison
from studies.running import Method
from studies.style import figure_style, save_figure


def _data(scene, bands=(2,)):
    methods = [
        Method(propagators.create(name), bands=n, iterations=6)
        for n in bands
        for name in ("lpv", "dom8")
    ]
    return comparison_data(compare(scene, methods))


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
def test_the_same_data_gives_the_same_bytes(tmp_path, ending):
    data = _data(load_scene("fig5-one-light"))
    files = []
    for name in ("a", "b"):
        with figure_style():
            files.append(save_figure(draw_comparison(data), tmp_path / f"{name}{ending}"))
    assert files[0].read_bytes() == files[1].read_bytes()


def test_large_grids_are_drawn_as_flux_maps(tmp_path):
    side = LARGEST_FOR_LOBES + 5
    light = {"kind": "area", "start": [10.0, 3.0], "end": [20.0, 3.0], "flux": 2.0}
    scene = Scene.from_dict({"grid": {"shape": [side, side]}, "light": [light]})
    with figure_style():
        figure = draw_comparison(_data(scene))
    assert len(figure.axes) == 4  # exact, two schemes, colour bar


def test_the_data_of_a_picture_holds_the_exact_flux():
    scene = load_scene("fig5-one-light")
    data = _data(scene)
    exact = propagators.create("analytic").solve(scene, 1)
    flux = data["exact"].values.mean(axis=0) * 2 * np.pi
    np.testing.assert_allclose(flux, exact.scalar_flux(), atol=2e-3)
