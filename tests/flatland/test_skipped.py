"""What a run says that it left out."""

from __future__ import annotations

import numpy as np
import pytest

import propagators
from flatland import Scene, Simulation, load_scene

LPV = propagators.create("lpv")


def explained(scene, steps=4, propagator=LPV, **options):
    simulation = Simulation(scene, propagator, **options)
    simulation.run(steps)
    return simulation, {skip.name: skip for skip in simulation.explain()}


def test_a_scene_without_occluders_needs_no_blocking():
    simulation, skips = explained(load_scene("fig5-one-light"))
    assert "no occluders" in skips["blocking"].reason
    assert simulation.octree.levels[0].occlusion.transmittance is None
    assert {"beams", "bounces"}.isdisjoint(skips)


def test_walls_that_are_not_asked_for_need_none_either():
    _, skips = explained(load_scene("shelf"), blocking="none")
    assert "no wall" in skips["blocking"].reason


def test_walls_touch_few_links_and_cells():
    simulation, skips = explained(load_scene("cornell-2d"), steps=100)
    assert 0 < skips["bounces"].saved < 1
    assert "blocking" not in skips
    black, told = explained(load_scene("cornell-2d"), steps=100, bounces=False)
    assert told["bounces"].saved is None
    assert black.ledger.reflected.sum() == 0 < simulation.ledger.reflected.sum()


def test_grey_light_in_colours_is_stepped_once():
    light = {"kind": "cell", "cell": [2, 2], "flux": [1.0, 2.0, 4.0]}
    scene = Scene.from_dict({"grid": {"shape": [8, 8]}, "light": [light]})
    simulation, skips = explained(scene)
    assert skips["spectra"].saved == pytest.approx(2 / 3)
    assert len(simulation.octree.levels[0].states) == 1


def test_cells_that_light_never_came_to():
    light = {"kind": "cell", "cell": [45, 45], "flux": 1.0}
    scene = Scene.from_dict({"grid": {"shape": [91, 91]}, "light": [light]})
    _, skips = explained(scene, steps=5)
    assert skips["cells"].saved == pytest.approx(1 - 11**2 / 91**2)
    _, skips = explained(scene, steps=5, skip=False)
    assert "cells" not in skips


def test_levels_that_nothing_reads():
    simulation, skips = explained(load_scene("level-jump"), steps=12, levels=5)
    simulation.merge()
    idle = [n for n, level in enumerate(simulation.octree.levels) if level.iteration == 0]
    assert idle
    assert all(str(n) in skips["levels"].reason for n in idle)


def test_couplings_are_those_that_are_zero():
    simulation, skips = explained(load_scene("fig5-one-light"))
    transfer = simulation.stencil.transfer
    zero = np.mean(np.abs(transfer) <= 8 * np.finfo(float).eps * np.abs(transfer).max())
    assert skips["couplings"].saved == pytest.approx(zero)


def test_light_that_was_dropped_is_named_with_its_share():
    simulation, skips = explained(load_scene("fig5-one-light"), steps=200, drop=1e-3)
    share = abs(float(simulation.ledger.dropped)) / float(simulation.ledger.emitted)
    assert share > 0
    assert f"{share:.2g} of the flux" in skips["light"].reason
