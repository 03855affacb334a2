"""Exact beams against LPV's customary 2N steps, and in a scene full of walls."""

from __future__ import annotations

import numpy as np
from conftest import best_seconds

import propagators
from flatland import Scene, Simulation, load_scene
from flatland.harmonics import CircularHarmonics
from propagators.analytic.geometry import read_geometry
from propagators.beam.flight import Transport
from propagators.transport.arrangement import arrange
from propagators.transport.ordinates import Ordinates
from propagators.transport.surface_elements import cut_elements

_SIDE, _BANDS = 96, 4
#: Two slanted lights and four slanted walls, in cells of a grid of 24.
_LIGHTS = [((3.0, 2.5), (9.0, 4.0), 3.0), ((18.0, 20.0), (15.0, 14.0), 2.0)]
_WALLS = [((5, 8), (10, 11)), ((12, 4), (14, 9)), ((3, 14), (8, 18)), ((14, 10), (18, 12))]


def _scaled(point: tuple[float, float]) -> list[float]:
    return [x * _SIDE / 24 for x in point]


def _room() -> Scene:
    return Scene.from_dict(
        {
            "grid": {"shape": [_SIDE, _SIDE]},
            "light": [
                {"kind": "area", "start": _scaled(a), "end": _scaled(b), "flux": flux}
                for a, b, flux in _LIGHTS
            ],
            "occluder": [
                {"kind": "segment", "start": _scaled(a), "end": _scaled(b)} for a, b in _WALLS
            ],
        }
    )


def test_beams_take_a_third_of_the_time_of_lpv(report, monkeypatch):
    """M = 4N ordinates against 2N steps, n = 4, exact blocking, float64, one thread.

    Like with like: the flight against the steps, and all that a user waits for on both sides.
    """
    monkeypatch.setenv("FLATLAND_THREADS", "1")
    scene = _room()
    beam = propagators.create("beam", ordinates=4 * _SIDE)
    surfaces = cut_elements(arrange(read_geometry(scene)), 0.5)
    transport = Transport(surfaces, Ordinates(4 * _SIDE), (_SIDE, _SIDE))
    basis = CircularHarmonics(_BANDS)
    simulation = Simulation(scene, propagators.create("lpv"), bands=_BANDS)

    def run() -> None:
        simulation.inject()
        simulation.run(2 * _SIDE)

    def start_and_run() -> None:
        Simulation(scene, propagators.create("lpv"), bands=_BANDS).run(2 * _SIDE)

    flight = best_seconds(lambda: transport.fly(surfaces.radiance, basis), 40)
    steps = best_seconds(run, 40)
    whole = best_seconds(lambda: beam.solve(scene, _BANDS), 40)
    lpv = best_seconds(start_and_run, 10)
    exact = propagators.create("analytic").solve(scene, _BANDS).values
    error = np.linalg.norm(beam.solve(scene, _BANDS).values - exact) / np.linalg.norm(exact)
    report(
        f"beam {_SIDE}², M = {4 * _SIDE}, error {error:.1e}: {flight * 1e3:.1f} ms; LPV "
        f"{2 * _SIDE} steps {steps * 1e3:.1f} ms ({steps / flight:.1f} x); from the scene to the "
        f"field {whole * 1e3:.1f} ms; LPV {lpv * 1e3:.1f} ms ({lpv / whole:.1f} x)"
    )
    assert error < 2e-3
    assert steps >= 3 * flight
    assert lpv >= 3 * whole


def test_a_thousand_walls(report):
    """256², M = 1,024."""
    scene = load_scene("clutter:size=256,occluders=1000")
    beam = propagators.create("beam", ordinates=1024)
    seconds = best_seconds(lambda: beam.solve(scene, _BANDS), 3)
    report(f"beam 256², 1,000 walls, 1,024 ordinates: {seconds:.2f} s")
    assert seconds < 5.0


def test_bounces(report):
    """What walls that reflect cost: some twenty flights past the cells."""
    data = load_scene("clutter:size=128,occluders=200").to_dict()
    seconds = {}
    for albedo in (0.0, 0.5):
        data["occluder"] = [dict(wall, albedo=albedo) for wall in data["occluder"]]
        scene = Scene.from_dict(data)
        beam = propagators.create("beam")
        seconds[albedo] = best_seconds(lambda s=scene, b=beam: b.solve(s, _BANDS), 1)
    report(
        f"beam 128², 200 walls, 512 ordinates: black {seconds[0.0]:.2f} s, of albedo 0.5 "
        f"{seconds[0.5]:.2f} s"
    )
