"""Only cells that light is in are swept, and nobody can tell."""

from __future__ import annotations

import numpy as np
import pytest
from schemes import every_scheme, stencil_classes

import propagators
from flatland import InputError, Scene, Simulation, load_scene
from flatland.kernels import Layout, programs
from flatland.kernels.box import (
    cell_count,
    cells_of,
    clear_outside,
    grown,
    is_empty,
    nothing,
    trimmed,
    whole,
)

SHAPES = [(1, 1), (7, 9), (4, 33), (3, 4, 5), (2, 5, 17)]
LPV = propagators.create("lpv")
DEFAULTS = [(scheme(), d) for scheme in stencil_classes() for d in scheme.dimensions]


def filled(shape, box, rng, size=3):
    """A layout and a buffer with light in every cell of a box."""
    layout = Layout(shape, size, np.dtype(float))
    buffer = layout.allocate()
    layout.view(buffer)[cells_of(box)] = rng.uniform(1, 2, (size, *(b - a for a, b in box)))
    return layout, buffer


def any_box(shape, rng):
    ends = [np.sort(rng.integers(0, cells + 1, 2)) for cells in shape]
    return tuple((min(int(a), cells - 1), max(int(b), min(int(a), cells - 1) + 1))
                 for (a, b), cells in zip(ends, shape))  # fmt: skip


@pytest.fixture
def any_box_pays(monkeypatch):
    """Steps for a box are compiled at once, and taken for every box."""
    monkeypatch.setattr(programs, "_COMPILING", -1)
    monkeypatch.setattr(programs, "_WORTH_A_BOX", 10**9)


class TestBox:
    @pytest.mark.parametrize("shape", SHAPES, ids=str)
    def test_trimming_finds_the_cells_with_light(self, shape, rng):
        for _ in range(20):
            box = any_box(shape, rng)
            layout, buffer = filled(shape, box, rng)
            before = buffer.copy()
            found, dropped = trimmed(layout.view(buffer), whole(shape))
            assert found == box
            assert not dropped.any()
            np.testing.assert_array_equal(buffer, before)

    @pytest.mark.parametrize("shape", SHAPES, ids=str)
    def test_a_dark_grid_has_an_empty_box(self, shape):
        layout = Layout(shape, 2, np.dtype(float))
        found, _ = trimmed(layout.view(layout.allocate()), whole(shape))
        assert is_empty(found)
        assert grown(found, shape, 5) == nothing(shape)

    def test_outer_layers_below_the_limit_are_dropped_and_added_up(self, rng):
        layout, buffer = filled((9, 20), ((3, 6), (5, 15)), rng)
        view = layout.view(buffer)
        view[:, 2, 5:15] = 1e-4 * rng.normal(size=(3, 10))
        view[:, 4, 16] = [1e-4, -1e-4, 5e-5]
        small = view[:, 2].sum(axis=1) + view[:, 4, 16]
        found, dropped = trimmed(layout.view(buffer), whole((9, 20)), 1e-3)
        assert found == ((3, 6), (5, 15))
        np.testing.assert_allclose(dropped, small, rtol=1e-12)
        assert not view[:, 2].any()
        assert not view[:, 4, 16].any()

    def test_small_light_between_bright_light_stays(self, rng):
        layout, buffer = filled((9, 20), ((3, 6), (5, 15)), rng)
        layout.view(buffer)[:, 4, 9] = 1e-9
        assert trimmed(layout.view(buffer), whole((9, 20)), 1e-3)[0] == ((3, 6), (5, 15))
        assert layout.view(buffer)[0, 4, 9] == 1e-9

    @pytest.mark.parametrize("shape", SHAPES, ids=str)
    def test_clearing_leaves_the_new_box_alone(self, shape, rng):
        for _ in range(20):
            old, new = any_box(shape, rng), any_box(shape, rng)
            layout, buffer = filled(shape, old, rng)
            expected = np.zeros((3, *shape))
            expected[cells_of(new)] = layout.view(buffer)[cells_of(new)]
            clear_outside(layout, buffer, old, new)
            np.testing.assert_array_equal(layout.view(buffer), expected)


def lone_light(dimension, **more):
    shape = [21, 40] if dimension == 2 else [9, 8, 20]
    cell = [4, 33] if dimension == 2 else [2, 5, 16]
    light = {"kind": "cell", "cell": cell, "flux": 2.0}
    return Scene.from_dict({"grid": {"shape": shape}, "light": [light], **more})


def walls(dimension):
    if dimension == 2:
        return [{"kind": "segment", "start": [7.3, 20.0], "end": [8.0, 40.0], "albedo": 0.6}]
    corners = [[4.2, 0.0, 10.0], [4.2, 8.0, 10.0], [4.2, 8.0, 20.0], [4.2, 0.0, 20.0]]
    return [{"kind": "quad", "vertices": corners, "albedo": 0.6}]


def assert_runs_agree(scene, propagator, pieces, **options):
    """All fields bit for bit, the books to rounding."""
    some, all_ = (Simulation(scene, propagator, skip=skip, **options) for skip in (True, False))
    for piece in pieces:
        for simulation in (some, all_):
            simulation.run(piece)
        for name in ("source", "target", "accumulated"):
            np.testing.assert_array_equal(getattr(some, name).values, getattr(all_, name).values)
    ours, theirs = some.ledger.as_dict(), all_.ledger.as_dict()
    for name, value in theirs.items():
        np.testing.assert_allclose(ours[name], value, atol=1e-12)
    return some


@every_scheme()
def test_skipping_changes_no_bit(propagator, dimension, any_box_pays):
    some = assert_runs_agree(lone_light(dimension), propagator, [1, 2, 7])
    state = some.octree.levels[0].states[0]
    assert state.swept < state.sweepable


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
@pytest.mark.parametrize(("propagator", "dimension"), DEFAULTS, ids=str)
def test_skipping_changes_no_bit_among_walls(propagator, dimension, blocking, any_box_pays):
    scene = lone_light(dimension, occluder=walls(dimension))
    assert_runs_agree(scene, propagator, [3, 20], blocking=blocking)


@pytest.mark.parametrize("shape", [(21, 7), (21, 40), (5, 64), (9, 8, 20)], ids=str)
@pytest.mark.parametrize("blocking", ["exact", "none"])
def test_whole_planes_and_boxes_are_the_same(shape, blocking, monkeypatch):
    """What is taken for a box is a matter of speed alone; rows shorter and longer than vectors."""
    lights = [{"kind": "cell", "cell": [n // 3 for n in shape], "flux": 1.0}]
    wall = walls(len(shape))[0] if len(shape) == 3 else {
        "kind": "segment", "start": [1.0, 1.2], "end": [4.5, 6.0], "albedo": 0.6
    }  # fmt: skip
    scene = Scene.from_dict({"grid": {"shape": list(shape)}, "light": lights, "occluder": [wall]})
    results = []
    for least in (10**9, 0):
        monkeypatch.setattr(programs, "_WORTH_A_BOX", least)
        monkeypatch.setattr(programs, "_COMPILING", -1)
        simulation = Simulation(scene, LPV, bands=3, blocking=blocking)
        for piece in (1, 2, 9, 30):
            simulation.run(piece)
        level = simulation.octree.levels[0]
        boxed = "steps_in_box" in vars(level._sweeps[0].programs)
        assert boxed is (least > 0 and shape != (21, 7))  # a row that is one vector
        results.append(simulation.accumulated.values)
    np.testing.assert_array_equal(*results)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_box_that_light_has_left_is_forgotten(precision):
    """Buffers are used in turn: what an older step left in one must not come back."""
    lights = [{"kind": "cell", "cell": [1, 2], "direction": [1.0, 0.0], "flux": 1.0}]
    scene = Scene.from_dict({"grid": {"shape": [60, 5]}, "light": lights})
    stepper = propagators.create("dom4")
    some = assert_runs_agree(
        scene, stepper, [1, 1, 17, 5, 40], bands=1, precision=precision, blocking="none"
    )
    assert some.iteration == 64


def room():
    """A closed room of 6 x 6 cells in a grid of 200 x 200, with a light in it."""
    corners = [[10.0, 10.0], [16.0, 10.0], [16.0, 16.0], [10.0, 16.0]]
    return Scene.from_dict(
        {
            "grid": {"shape": [200, 200]},
            "light": [{"kind": "cell", "cell": [12, 12], "flux": 1.0}],
            "occluder": [
                {"kind": "segment", "start": corners[i], "end": corners[(i + 1) % 4], "albedo": 0.9}
                for i in range(4)
            ],
        }
    )


@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8"])
def test_light_in_a_closed_room_does_not_touch_the_outside(name):
    simulation = Simulation(room(), propagators.create(name), bands=3)
    simulation.run(300)
    state = simulation.octree.levels[0].states[0]
    # Sixteen cells round the room are swept before the next look, no more.
    assert state.swept <= 300 * (6 + 2 * 16) ** 2
    assert simulation.ledger.left == 0


class TestDropping:
    @every_scheme(lambda propagator: not propagator.values.get("clamp"))
    def test_books_close_and_nothing_is_left_to_move(self, propagator, dimension):
        simulation = Simulation(lone_light(dimension), propagator, drop=1e-3)
        simulation.run(4000)
        ledger = simulation.ledger
        assert abs(float(ledger.closure)) < 1e-12 * float(ledger.emitted)
        assert float(ledger.inside) == pytest.approx(0, abs=1e-12)
        assert not simulation.target.values.any()
        state = simulation.octree.levels[0].states[0]
        assert state.swept < 0.9 * state.sweepable
        assert simulation.iteration == 4000

    def test_less_is_dropped_the_smaller_the_tolerance_and_nothing_at_zero(self):
        scene = load_scene("fig5-one-light")
        exact = Simulation(scene, LPV)
        exact.run(600)
        size = np.linalg.norm(exact.accumulated.values)
        errors, fluxes = [], []
        for drop in (1e-2, 1e-4, 1e-6, 0.0):
            simulation = Simulation(scene, LPV, drop=drop)
            simulation.run(600)
            errors.append(np.linalg.norm(simulation.accumulated.values - exact.accumulated.values))
            fluxes.append(abs(float(simulation.ledger.dropped)))
        assert fluxes[0] > fluxes[1] > fluxes[2] > fluxes[3] == 0
        assert errors[0] > errors[1] > errors[2] > errors[3] == 0
        assert errors[1] < 0.02 * size

    @pytest.mark.parametrize("drop", [-1e-3, 1.0, np.nan, np.inf])
    def test_tolerances_that_cannot_be_are_refused(self, drop):
        with pytest.raises(InputError, match="drop"):
            Simulation(lone_light(2), LPV, drop=drop)

    def test_dropping_needs_skipping(self):
        with pytest.raises(InputError, match="skip"):
            Simulation(lone_light(2), LPV, drop=1e-3, skip=False)


def test_what_was_swept_is_counted():
    simulation = Simulation(lone_light(2), LPV)
    simulation.run(2)
    state = simulation.octree.levels[0].states[0]
    assert state.swept == 2 * cell_count(((2, 7), (31, 36)))
    assert state.sweepable == 2 * 21 * 40
