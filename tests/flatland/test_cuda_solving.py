"""Converged fields that a device finds are those of the processor; here on a stand-in."""

import numpy as np
import pytest
from on_device import (
    WALLS,
    WALLS_3D,
    Downloads,
    assert_close,
    assert_same_books,
    both,
    space_scene,
    stand_in,
)
from scenes import LIGHTS, LPV, coloured, quiet, scene_of
from schemes import every_scheme

import propagators
from flatland.errors import ConvergenceError, InputError, InstabilityError, SchemeWarning
from flatland.harmonics import basis_for
from flatland.scene import Scene
from flatland.solvers import watching
from flatland.stability import RADIUS_TOLERANCE

TOLERANCE = 1e-11
#: What an error of that size in (1 − A) x leaves in x here, and in fluxes.
NEAR = 1e-8


@pytest.fixture(autouse=True)
def cupy(monkeypatch):
    return stand_in(monkeypatch)


def walled(**arguments):
    return Scene.from_dict(
        {"grid": {"shape": (8, 7)}, "light": LIGHTS, "occluder": WALLS, **arguments}
    )


def has_an_answer(propagator):
    """Whether no wave of its light, with few bands, grows for ever; a clamped one's twin counts."""
    return all(
        propagator.stencil(basis_for(dimension, 2)).spectral_radius() <= 1 + RADIUS_TOLERANCE
        for dimension in propagator.dimensions
    )


def solve_both(scene, propagator, method="auto", tolerance=TOLERANCE, **arguments):
    """Both solved; the device's report."""
    pair = both(scene, propagator, **arguments)
    pair[0].solve(tolerance)
    return *pair, pair[1].solve(tolerance, method)


def assert_same_answer(here, there, near=NEAR):
    for number in range(here.levels):
        first, second = here.level(number), there.level(number)
        assert_close(second.accumulated.values, first.accumulated.values, near)
        assert_same_books(first.ledger, second.ledger, near)


@every_scheme(has_an_answer)
@pytest.mark.filterwarnings("ignore:a clamped step:flatland.errors.SchemeWarning")
def test_every_stable_scheme(propagator, dimension):
    scene = walled() if dimension == 2 else space_scene(WALLS_3D)
    here, there, report = solve_both(scene, propagator)
    assert report.residual <= TOLERANCE
    assert_same_answer(here, there)


@pytest.mark.parametrize("method", ["krylov", "stepping"])
@pytest.mark.parametrize("bounces", [True, False])
@pytest.mark.parametrize("blocking", ["exact", "fuzzy", "none"])
def test_walls_and_methods(blocking, bounces, method):
    options = {"blocking": blocking, "bounces": bounces, "bands": 3}
    here, there, report = solve_both(walled(), LPV, method, **options)
    assert report.method == method
    assert report.applications >= report.iterations > 3
    assert_same_answer(here, there)


@pytest.mark.parametrize("name", ["lpv", "dom8"])
def test_iterations_are_as_many(name):
    pair = both(walled(), propagators.create(name), bands=3)
    wanted, found = (simulation.solve(1e-9, "krylov") for simulation in pair)
    assert found.method == "krylov"
    assert abs(found.iterations - wanted.iterations) <= 2


@pytest.mark.parametrize("walls", [(), WALLS])
def test_fields_in_single_precision(walls):
    scene = scene_of() if not walls else walled()
    here, there, report = solve_both(scene, LPV, precision="float32")
    assert report.residual <= TOLERANCE  # of the answer in double precision
    assert there.accumulated.values.dtype == np.float32
    assert_same_answer(here, there, 1e-5)


def test_colours_levels_and_a_medium():
    scene = walled(medium={"extinction": 0.3, "albedo": 0.7}, light=coloured((1, 2), (3, 1)))
    here, there, _ = solve_both(scene, propagators.create("dom8"), levels=2, bands=3)
    assert_same_answer(here, there)


def test_the_residual_is_that_of_the_answer():
    """From the report's own words, with the operator of the processor."""
    here, there, report = solve_both(walled(), LPV, tolerance=1e-6)
    level = here.octree.levels[0]
    sweep, layout = level._sweeps[0], level.layout
    light, answer, defect = (layout.allocate() for _ in range(3))
    layout.view(answer)[...] = there.accumulated.values
    quiet_start = quiet(LPV, walled())
    quiet_start.inject()
    layout.view(light)[...] = quiet_start.target.values
    sweep.combine(-1.0, 1.0, 1.0, answer, light, defect)
    expected = np.linalg.norm(defect) / np.linalg.norm(light)
    assert report.residual == pytest.approx(expected, rel=1e-6)
    assert 0 < report.residual <= 1e-6


def test_a_solution_is_solved_on_the_device(monkeypatch):
    """Whatever the number of iterations, the same number of fields comes back."""
    counts = []
    for tolerance in (1e-3, 1e-11):
        simulation = quiet(LPV, walled(), device="cuda")
        downloads = Downloads(monkeypatch, simulation.octree.levels[0].layout.size)
        simulation.solve(tolerance)
        counts.append(downloads.count)
    assert counts[0] == counts[1] <= 4


def test_steps_after_a_solution_start_afresh():
    simulation, other = (quiet(LPV, walled(), device="cuda") for _ in range(2))
    simulation.solve(1e-9)
    simulation.run(5)
    other.run(5)
    np.testing.assert_array_equal(simulation.target.values, other.target.values)


def test_moved_lights():
    pair = both(walled(), LPV)
    for simulation in pair:
        simulation.solve(TOLERANCE)
        simulation.relight(walled(light=LIGHTS[1:3]))
        simulation.solve(TOLERANCE)
    assert_same_answer(*pair)


def test_a_clamped_scheme_is_solved_as_its_linear_twin():
    clamped = propagators.create("lpv", clamp=True)
    here, there = both(scene_of(), clamped)
    for simulation in (here, there):
        with pytest.warns(SchemeWarning, match="not linear"):
            simulation.solve(TOLERANCE)
    assert_same_answer(here, there)


def test_a_solver_can_be_watched():
    seen = []
    with watching.watched(seen.append):
        report = quiet(LPV, walled(), device="cuda").solve(1e-9)
    assert sum(seen) == report.applications


def test_dark_rooms_stay_dark():
    """Two rooms of white walls, a light in one of them."""
    room = [[1.0, 1.0], [4.0, 1.0], [4.0, 4.0], [1.0, 4.0]]
    other = [[x + 4.0, y + 4.0] for x, y in room]
    walls = [{"kind": "polygon", "vertices": v, "albedo": 0.9} for v in (room, other)]
    light = [{"kind": "cell", "cell": [2, 2], "flux": 1.0}]
    scene = Scene.from_dict({"grid": {"shape": (9, 9)}, "light": light, "occluder": walls})
    here, there, _ = solve_both(scene, LPV)
    assert_same_answer(here, there)
    assert not there.accumulated.values[:, 5:8, 5:8].any()


@pytest.mark.parametrize("method", ["multigrid", "mirrored", "factorization", "fast"])
def test_methods_that_a_device_does_not_have(method):
    simulation = quiet(LPV, scene_of(), device="cuda")
    with pytest.raises(InputError, match="auto, krylov, stepping"):
        simulation.solve(method=method)


@pytest.mark.parametrize("tolerance", [0, 1, -1e-3])
def test_tolerances_that_are_none(tolerance):
    with pytest.raises(InputError, match="between 0 and 1"):
        quiet(LPV, scene_of(), device="cuda").solve(tolerance)


def test_unstable_schemes_have_no_answer():
    scheme = propagators.create("dom8", emission="delta", flux="central")
    with pytest.raises(InstabilityError, match="spectral radius"):
        quiet(scheme, scene_of(), bands=5, device="cuda").solve()


def test_what_cannot_be_reached_is_said():
    """Rounding alone leaves more than this."""
    simulation = quiet(LPV, scene_of(), device="cuda")
    with pytest.raises(ConvergenceError, match="stopped at a relative residual"):
        simulation.solve(1e-19, "krylov")
    assert simulation.accumulated.values.any()
