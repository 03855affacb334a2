"""Steps on a device are those of the processor; here on a stand-in, with kernels for the host."""

import numpy as np
import pytest
from on_device import (
    SHAPE_3D,
    WALLS,
    WALLS_3D,
    Downloads,
    assert_alike,
    assert_close,
    both,
    run_both,
    space_scene,
    stand_in,
    walled_scene,
)
from scenes import LIGHTS, LPV, coloured, lobe_scene, quiet, scene_of
from schemes import every_scheme
from stepping import neighbours, random_stencil

import propagators
from flatland.cuda import find_cuda, step_text
from flatland.cuda.parts import block_for
from flatland.harmonics import basis_for
from flatland.kernels import Layout, Sweep
from flatland.patch import Patch
from flatland.scene import Scene

DOM8 = propagators.create("dom8")
CLAMPED = propagators.create("lpv", clamp=True)


@pytest.fixture(autouse=True)
def cupy(monkeypatch):
    return stand_in(monkeypatch)


@every_scheme()
def test_every_scheme(propagator, dimension):
    assert_alike(*run_both(walled_scene(dimension), 7, propagator))


@pytest.mark.parametrize("propagator", [LPV, DOM8, CLAMPED], ids=str)
@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("bounces", [True, False])
@pytest.mark.parametrize("blocking", ["exact", "fuzzy", "none"])
def test_walls(propagator, precision, bounces, blocking):
    options = {"blocking": blocking, "precision": precision, "bounces": bounces, "bands": 3}
    pair = run_both(walled_scene(2), 19, propagator, **options)
    assert_alike(*pair)
    assert (pair[1].ledger.reflected > 0) == (bounces and blocking != "none")


@pytest.mark.parametrize("name", ["lpv", "dom6", "dom26"])
@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
def test_walls_in_space(name, precision, blocking):
    scene, scheme = space_scene(WALLS_3D), propagators.create(name)
    assert_alike(*run_both(scene, 9, scheme, bands=3, precision=precision, blocking=blocking))


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (33, 2), (3, 1, 17)])
def test_any_shape(shape):
    scheme = DOM8 if len(shape) == 2 else propagators.create("dom26")
    assert_alike(*run_both(lobe_scene(shape), 3, scheme, bands=2))


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("blocked", [False, True])
@pytest.mark.parametrize("looped", [False, True])
def test_a_scheme_without_any_symmetry(rng, monkeypatch, clamp, dimension, blocked, looped):
    """Written out and in loops; five coefficients or nine, and sums of three of them."""
    if looped:
        monkeypatch.setattr(step_text, "LARGEST_TEXT", 0)
    basis, shape = basis_for(dimension, 3), (7, 5, 6)[:dimension]
    stencil = random_stencil(
        rng, basis, neighbours(dimension), faces=4 if clamp else 0, clamp=clamp
    )
    tau = rng.uniform(size=(len(stencil.offsets), *shape)) if blocked else None
    layout = Layout(shape, basis.size, np.dtype(float))
    pair = (
        Sweep(stencil, layout, tau, (0, 2, 4)),
        find_cuda().sweep(stencil, layout, tau, (0, 2, 4)),
    )
    assert pair[1]._text.looped == looped
    light = rng.normal(size=(basis.size, *shape))
    found = []
    for sweep in pair:
        fields = [layout.allocate() for _ in range(3)]
        layout.view(fields[0])[...] = light
        sums = sweep.steps(*fields, 5)
        combined = layout.allocate()
        sweep.combine(0.3, -1.7, 0.9, fields[0], fields[2], combined)
        numbers = [sums.components, sums.squares, sums.left]
        found.append([*fields, combined, *numbers, *([sums.sent] if clamp else [])])
    for wanted, other in zip(*found):
        assert_close(other, wanted, 1e-12)


def test_more_steps_than_are_reported_at_once(rng):
    stencil = LPV.stencil(basis_for(2, 2))
    layout = Layout((9, 8), 3, np.dtype(float))
    reports = []
    for sweep in (Sweep(stencil, layout), find_cuda().sweep(stencil, layout, None, (0,))):
        fields = [layout.allocate() for _ in range(3)]
        layout.view(fields[0])[0] = 1.0
        reports.append((sweep.steps(*fields, 37), fields))
    (wanted, here), (found, there) = reports
    assert found.left.shape == (37,)
    assert_close(found.components, wanted.components, 1e-13)
    for field, other in zip(here, there):
        assert_close(other, field, 1e-13)


def test_many_bands_are_read_from_a_table():
    """2D, 12 bands: 2,852 couplings; the sums of a scheme that does not conserve flux."""
    pair = run_both(walled_scene(2), 5, propagators.create("dom8"), bands=12)
    assert pair[1].octree.levels[0]._sweeps[0]._text.looped
    assert_alike(*pair)


def test_blocks_that_add_up_much_are_small():
    """48 KiB of shared memory, in numbers of 8 bytes."""
    assert [block_for(sums) for sums in (1, 24, 25, 50, 127)] == [256, 256, 128, 64, 32]
    assert all(sums * block_for(sums) <= 6144 for sums in range(1, 300))


@pytest.mark.parametrize("propagator", [LPV, CLAMPED], ids=str)
def test_threads_of_a_block_wait_for_each_other(cupy, rng, propagator):
    """As many threads as on a device, all at once; two blocks, with light in all cells."""
    cupy.threaded = True
    scene = walled_scene(2, shape=(20, 19))
    pair = both(scene, propagator, skip=False)
    light = rng.uniform(1, 2, (3, 20, 19))
    for simulation in pair:
        simulation.inject()
        simulation.octree.levels[0].start([Patch.everywhere(light)])
        simulation.run(2)
    assert_alike(*pair)


def test_colours_and_coloured_walls():
    scene = Scene.from_dict(
        {
            "grid": {"shape": (8, 7)},
            "light": coloured((1.0, 2.0, 3.0), (3.0, 1.0, 0.5)),
            "occluder": [dict(WALLS[0], albedo=[0.9, 0.5, 0.1]), WALLS[1]],
        }
    )
    pair = run_both(scene, 11, LPV)
    assert_alike(*pair)
    assert pair[1].ledger.reflected.shape == (3,)


@pytest.mark.parametrize("walls", [(), WALLS])
@pytest.mark.parametrize("name", ["lpv", "dom8"])
def test_a_medium(name, walls):
    scene = Scene.from_dict(
        {
            "grid": {"shape": (8, 7)},
            "light": LIGHTS,
            "occluder": list(walls),
            "medium": {"extinction": 0.4, "albedo": 0.8},
        }
    )
    pair = run_both(scene, 13, propagators.create(name), bands=3)
    assert_alike(*pair)
    assert pair[1].ledger.medium > 0


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
def test_levels_of_an_octree(blocking):
    scene = Scene.from_dict({"grid": {"shape": (16, 12)}, "light": LIGHTS, "occluder": WALLS})
    pair = run_both(scene, 5, LPV, levels=3, blocking=blocking)
    merged = [simulation.merge(blend=1.0).values for simulation in pair]
    assert_close(merged[1], merged[0], 1e-13)
    assert_alike(*pair)
    for simulation in pair:
        simulation.downsample()
        simulation.run(3)
    assert_alike(*pair)


def test_moved_lights_and_fresh_starts():
    pair = run_both(walled_scene(2), 6, DOM8)
    moved = pair[0].scene.model_copy(update={"lights": pair[0].scene.lights[1:3]})
    for simulation in pair:
        simulation.relight(moved)
        simulation.run(4)
    assert_alike(*pair)
    for simulation in pair:
        simulation.inject()
    assert_alike(*pair)


def test_reports_of_fewer_cells_than_before():
    """Of light in a corner, and then of some in the middle, far from the border."""
    shape = (40, 36)
    lights = [{"kind": "cell", "cell": cell, "flux": 1.0} for cell in ([0, 0], [20, 18])]
    scenes = [scene_of([light], shape) for light in lights]
    pair = run_both(scenes[0], 30, LPV)
    for simulation in pair:
        simulation.relight(scenes[1])
        simulation.run(2)
    assert_alike(*pair)
    assert pair[1].ledger.left == 0


@pytest.mark.parametrize("skip", [True, False])
def test_cells_that_light_has_not_reached(skip):
    pair = run_both(lobe_scene((40, 36)), 9, LPV, skip=skip)
    assert_alike(*pair)
    states = [simulation.octree.levels[0].states[0] for simulation in pair]
    assert (states[1].swept < states[1].sweepable) == skip


def test_light_below_a_limit_is_dropped():
    pair = run_both(lobe_scene((24, 24)), 40, LPV, drop=1e-3)
    assert_alike(*pair)
    assert pair[1].ledger.dropped > 0


def test_light_that_is_gone_is_not_stepped():
    stencil_light = [{"kind": "cell", "cell": [3, 3], "flux": 1.0}]
    tau = np.zeros((4, 8, 7))
    pair = both(scene_of(stencil_light), LPV, transmittance=tau)
    for simulation in pair:
        simulation.run(1)
        simulation.run(30)
    assert_alike(*pair)
    assert not pair[1].target.values.any()
    assert pair[1].ledger.absorbed == pytest.approx(1.0, rel=1e-12)


def test_unstable_light_is_stopped_in_time():
    scheme = propagators.create("dom8", emission="delta", flux="central")
    pair = both(scene_of(), scheme, bands=5)
    for simulation in pair:
        with pytest.raises(ArithmeticError, match="has grown by a factor"):
            simulation.run(4000)
    assert pair[0].iteration == pair[1].iteration
    assert_alike(*pair, tolerance=1e-10)


def test_fields_stay_on_the_device(monkeypatch):
    simulation = quiet(LPV, walled_scene(2), device="cuda")
    size = simulation.octree.levels[0].layout.size
    simulation.run(1)
    downloads = Downloads(monkeypatch, size)
    simulation.run(100)
    assert downloads.count == 0
    for _ in range(3):
        assert simulation.target.values.any()
    assert downloads.count == 1
    simulation.run(1)
    assert simulation.target.values.any()
    assert downloads.count == 2


def test_nobody_writes_in_a_copy_of_what_is_on_the_device():
    simulation = quiet(LPV, scene_of(), device="cuda")
    simulation.run(1)
    state = simulation.octree.levels[0].states[0]
    with pytest.raises(ValueError, match="read-only"):
        state.target[:] = 0


def test_the_same_run_twice_is_the_same_bit_for_bit():
    first, second = (quiet(DOM8, walled_scene(2), device="cuda") for _ in range(2))
    for simulation in (first, second):
        simulation.run(20)
    assert first.ledger.left == second.ledger.left
    np.testing.assert_array_equal(first.accumulated.values, second.accumulated.values)


def test_shapes_are_those_that_walls_are_in():
    """The scene in 3D is not one that walls leave alone."""
    tau = quiet(LPV, space_scene(WALLS_3D), device="cuda").octree.levels[0].occlusion.transmittance
    assert tau.shape == (6, *SHAPE_3D)
    assert (tau < 1).any()
