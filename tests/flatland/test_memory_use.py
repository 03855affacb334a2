"""What a run takes: three fields, and little beside."""

import tracemalloc

import numpy as np
import pytest

import propagators
from flatland import Scene, Simulation
from flatland import memory as memory_module
from flatland.kernels import Layout
from flatland.memory import PeakMemory, megabytes

SIDE = 512


def room(occluders=(), **grid):
    light = {"kind": "area", "start": [100.0, 1.0], "end": [300.0, 1.0], "flux": 5.0}
    shape = {"shape": [SIDE, SIDE], **grid}
    return Scene.from_dict({"grid": shape, "light": [light], "occluder": list(occluders)})


WALL = {"kind": "segment", "start": [300.0, 90.0], "end": [420.0, 300.0], "albedo": 0.5}


def test_a_peak_is_what_was_used_at_once():
    warm = np.ones(1_000_000)
    peak = PeakMemory()
    if peak.taken is None:
        pytest.skip("the system does not tell")
    for _ in range(3):
        used = np.ones(8_000_000)
        del used
    assert 60_000_000 < peak.taken < 80_000_000
    assert PeakMemory().taken < 10_000_000
    assert warm.all()


def test_no_peak_where_the_system_does_not_tell(monkeypatch):
    def closed(*_):
        raise OSError

    monkeypatch.setattr(memory_module, "_entry", closed)
    assert PeakMemory().taken is None


def test_megabytes_are_read_at_a_glance():
    assert megabytes(3 * 2**20 + 2**19) == "3.5 MiB"


@pytest.mark.parametrize(("bands", "precision"), [(2, "float32"), (5, "float64")])
def test_a_run_takes_little_beside_its_fields(bands, precision):
    """Small runs first: code is compiled, libraries are loaded."""
    lpv = propagators.create("lpv")
    for side in (SIDE, 1024):
        peak = PeakMemory()
        scene = room(shape=[side, side])
        simulation = Simulation(scene, lpv, bands=bands, precision=precision)
        simulation.run(20)
    if peak.taken is None:
        pytest.skip("the system does not tell")
    layout = Layout((1024, 1024), 2 * bands - 1, np.dtype(precision))
    assert simulation.field_bytes == 3 * layout.size * layout.dtype.itemsize
    assert peak.taken <= 1.1 * simulation.field_bytes + 4_000_000


@pytest.mark.parametrize("walls", [[], [WALL]], ids=["open", "reflecting"])
@pytest.mark.parametrize("options", [{}, {"clamp": True}], ids=["linear", "clamped"])
def test_a_step_allocates_no_field(walls, options):
    simulation = Simulation(room(walls), propagators.create("lpv", **options))
    simulation.run(4)
    tracemalloc.start()
    try:
        simulation.run(16)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # A row of the grid has 4 kB a component; the whole one 6 MB.
    assert peak < 200_000


def test_fields_of_all_levels_and_spectra_count():
    data = room().to_dict()
    one = Simulation(Scene.from_dict(data), propagators.create("lpv")).field_bytes
    several = Simulation(Scene.from_dict(data), propagators.create("lpv"), levels=3).field_bytes
    assert 1.3 * one < several < 1.4 * one
