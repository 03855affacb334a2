"""Converged fields: every method, the same answer, and no promise that is not kept."""

import warnings
from collections import OrderedDict

import numpy as np
import pytest
from scenes import LPV, lobe_scene, scene_of
from scipy.sparse import eye_array
from scipy.sparse.linalg import spsolve
from stepping import Stepper, neighbours, operator, random_stencil

import propagators
from flatland.errors import ConvergenceError, InputError, InstabilityError, SchemeWarning
from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from flatland.kernels import sweep as sweep_module
from flatland.simulation import Simulation
from flatland.solvers import METHODS, factorization, solve_converged

#: What is asked of a solver, and how far its answer may then be off: these operators have
#: condition numbers of some hundred.
TOLERANCE, ERROR = 1e-12, 1e-9
#: Every link blocked at random is more than multigrid, which sees no walls, can precondition.
EVERYWHERE, HERE_AND_THERE = 1.0, 0.1
SCHEMES = {
    "lpv": ("lpv", 2, {}),
    "lpv central, 5 bands": ("lpv", 5, {"flux": "central"}),
    "lpv-2009": ("lpv-2009", 3, {}),
    "dom4 peaks": ("dom4", 2, {"emission": "delta"}),
    "dom8": ("dom8", 3, {}),
}
every_case = pytest.mark.parametrize(
    ("name", "bands", "options"), list(SCHEMES.values()), ids=SCHEMES
)
every_shape = pytest.mark.parametrize("shape", [(1, 1), (2, 2), (3, 7), (1, 40), (24, 20)], ids=str)
open_or_blocked = pytest.mark.parametrize(
    "blocked", [0.0, HERE_AND_THERE, EVERYWHERE], ids=["open", "some walls", "walls everywhere"]
)


@pytest.fixture(autouse=True)
def no_factors_at_hand(monkeypatch):
    """Every test starts without factors of earlier ones."""
    monkeypatch.setattr(factorization, "_factors", OrderedDict())


def stencil_of(name, bands, options=None):
    return propagators.create(name, **(options or {})).stencil(CircularHarmonics(bands))


class Problem:
    """(1 − A) S_A = S_0 for random light; `blocked`: share of links that are partly blocked."""

    def __init__(self, stencil, shape, rng, blocked=0.0):
        self.transmittance = None
        if blocked:
            links = (len(stencil.offsets), *shape)
            open_links = rng.uniform(size=links) >= blocked
            self.transmittance = np.where(open_links, 1.0, rng.uniform(size=links))
        self.stepper = Stepper(stencil, shape, self.transmittance)
        self.light = rng.normal(size=(stencil.basis.size, *shape))
        self.matrix = eye_array(self.light.size) - operator(stencil, shape, self.transmittance)

    def solve(self, method="auto", tolerance=TOLERANCE):
        right, answer = self.stepper.buffer(self.light), self.stepper.buffer()
        report = solve_converged(self.stepper.sweep, right, answer, tolerance, method)
        return self.stepper.layout.view(answer).copy(), report

    def exact(self):
        """By a sparse matrix that was put together in another way."""
        return spsolve(self.matrix.tocsc(), self.light.ravel()).reshape(self.light.shape)

    def residual(self, answer):
        light = self.light.ravel()
        return np.linalg.norm(light - self.matrix @ answer.ravel()) / np.linalg.norm(light)


@every_case
@open_or_blocked
def test_all_methods_find_the_solution(name, bands, options, blocked, rng):
    problem = Problem(stencil_of(name, bands, options), (24, 20), rng, blocked)
    expected = problem.exact()
    scale = np.abs(expected).max()
    for method in ("krylov", "stepping", "factorization"):
        found, report = problem.solve(method)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ERROR * scale, err_msg=method)
        assert report.method == method


@every_case
@open_or_blocked
def test_left_to_itself_the_solver_finds_a_method_that_works(name, bands, options, blocked, rng):
    problem = Problem(stencil_of(name, bands, options), (24, 20), rng, blocked)
    expected, (found, report) = problem.exact(), problem.solve("auto")
    assert report.residual <= TOLERANCE
    np.testing.assert_allclose(found, expected, rtol=0, atol=ERROR * np.abs(expected).max())


@pytest.mark.parametrize("blocked", [0.0, HERE_AND_THERE], ids=["open", "some walls"])
@pytest.mark.parametrize("name", ["lpv", "lpv central, 5 bands", "lpv-2009"])
def test_multigrid_finds_the_solution_of_schemes_that_diffuse(name, blocked, rng):
    scheme, bands, options = SCHEMES[name]
    problem = Problem(stencil_of(scheme, bands, options), (24, 20), rng, blocked)
    expected, (found, report) = problem.exact(), problem.solve("multigrid")
    np.testing.assert_allclose(found, expected, rtol=0, atol=ERROR * np.abs(expected).max())
    assert report.method == "multigrid"


def test_multigrid_says_where_it_does_not_converge(rng):
    """DOM8 carries light in straight lines, which a coarse grid does not see."""
    problem = Problem(stencil_of("dom8", 3), (24, 20), rng, EVERYWHERE)
    with pytest.raises(ConvergenceError, match="multigrid stopped at a relative residual"):
        problem.solve("multigrid")
    assert problem.solve("auto")[1].method != "multigrid"


@every_shape
@pytest.mark.parametrize("method", ["auto", "aggregation", "krylov", "factorization", "stepping"])
def test_odd_and_tiny_grids_are_solved(shape, method, rng):
    problem = Problem(stencil_of("lpv", 3), shape, rng, blocked=EVERYWHERE)
    expected = problem.exact()
    scale = np.abs(expected).max()
    np.testing.assert_allclose(problem.solve(method)[0], expected, rtol=0, atol=ERROR * scale)


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (3, 7), (33, 31), (64, 5)], ids=str)
def test_multigrid_takes_any_shape_of_grid(shape, rng):
    problem = Problem(stencil_of("lpv", 2), shape, rng)
    expected = problem.exact()
    scale = np.abs(expected).max()
    np.testing.assert_allclose(problem.solve("multigrid")[0], expected, rtol=0, atol=ERROR * scale)


def test_solution_in_three_dimensions(rng):
    stencil = random_stencil(rng, SphericalHarmonics(1), neighbours(3, diagonal=False))
    stencil = stencil.scaled(0.9 / stencil.spectral_radius())
    problem = Problem(stencil, (4, 5, 3), rng)
    for method in ("auto", "multigrid", "krylov"):
        found, _ = problem.solve(method)
        np.testing.assert_allclose(found, problem.exact(), atol=ERROR, err_msg=method)


def test_solution_by_matrix_products(rng, monkeypatch):
    """As for stencils with more couplings than can be written out."""
    monkeypatch.setattr(sweep_module, "LARGEST_TEXT", 0)
    problem = Problem(stencil_of("lpv", 2), (12, 9), rng, blocked=EVERYWHERE)
    for method in ("multigrid", "krylov", "stepping"):
        found, _ = problem.solve(method)
        np.testing.assert_allclose(found, problem.exact(), atol=ERROR, err_msg=method)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("blocked", [0.0, HERE_AND_THERE], ids=["open", "some walls"])
def test_reported_residual_is_the_true_one(method, blocked, rng):
    problem = Problem(stencil_of("lpv", 2), (24, 20), rng, blocked)
    found, report = problem.solve(method, 1e-6)
    assert report.residual <= report.tolerance == 1e-6
    # A factorisation ends at rounding, where residuals of two summations differ.
    assert report.residual == pytest.approx(problem.residual(found), rel=1e-6, abs=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_applications_of_the_operator_are_counted(method, rng):
    _, report = Problem(stencil_of("lpv", 2), (24, 20), rng).solve(method, 1e-6)
    if method == "factorization":
        assert (report.applications, report.iterations) == (0, 0)
    else:
        assert report.applications >= report.iterations > 0
    assert report.seconds > 0


@pytest.mark.parametrize(
    "method", ["multigrid", "aggregation", "krylov", "stepping", "factorization", "auto"]
)
def test_a_tolerance_that_cannot_be_reached_is_an_error(method, rng):
    problem = Problem(stencil_of("lpv", 2), (12, 11), rng)
    right, answer = problem.stepper.buffer(problem.light), problem.stepper.buffer()
    with pytest.raises(ConvergenceError, match=r"not 1.00e-17") as caught:
        solve_converged(problem.stepper.sweep, right, answer, 1e-17, method)
    reached = problem.residual(problem.stepper.layout.view(answer))
    said = float(str(caught.value).partition("residual of ")[2].partition(",")[0])
    assert 1e-17 < said < 1e-12
    # Both are rounding, in two orders of summation.
    assert 0.01 * reached < said < 100 * reached


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-8, np.nan, np.inf])
def test_bad_tolerance_is_refused(tolerance, rng):
    with pytest.raises(InputError, match=r"tolerance = .*must lie between 0 and 1"):
        Problem(stencil_of("lpv", 2), (4, 4), rng).solve(tolerance=tolerance)


def test_unknown_method_lists_the_methods(rng):
    with pytest.raises(InputError, match="method = 'magic': is unknown; accepted: auto, multigrid"):
        Problem(stencil_of("lpv", 2), (4, 4), rng).solve("magic")


def test_growing_scheme_has_no_solution(rng):
    problem = Problem(stencil_of("lpv", 2, {"propagation_factor": 1.1}), (4, 4), rng)
    with pytest.raises(InstabilityError, match=r"spectral radius is 1\.1000, above 1"):
        problem.solve()


def test_no_light_has_a_solution_without_light():
    simulation = Simulation(scene_of([]), LPV)
    report = simulation.solve()
    assert report.residual == 0
    assert not simulation.accumulated.values.any()


# -- against stepping -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("side", "steps"), [(64, 20_000), pytest.param(128, 32_000, marks=pytest.mark.slow)]
)
def test_solution_is_where_thousands_of_steps_lead(side, steps):
    """Light diffuses by 2.31 squared cells a step (see the random walk of LPV).

    The slowest wave that fits into the grid thus fades by exp(−1.155 π²/N²) a step; after these
    steps it is at 1e-9 or less of what it was.
    """
    scene = lobe_scene((side, side))
    solved, stepped = Simulation(scene, LPV), Simulation(scene, LPV)
    solved.solve(1e-11)
    stepped.run(steps)
    expected = stepped.accumulated.values
    scale = np.abs(expected).max()
    np.testing.assert_allclose(solved.accumulated.values, expected, rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize("side", [64, 128, pytest.param(256, marks=pytest.mark.slow)])
def test_work_does_not_grow_with_the_grid(side):
    """Applications of the operator, the multigrid cycles' own included (numerics §3: about 50)."""
    report = Simulation(lobe_scene((side, side)), LPV).solve(1e-8, "multigrid")
    assert report.applications <= 80


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_solution_in_the_precision_of_the_fields(precision):
    single = Simulation(scene_of(), LPV, precision=precision)
    report = single.solve(1e-10)
    assert report.residual <= 1e-10
    exact = Simulation(scene_of(), LPV)
    exact.solve(1e-12)
    assert single.accumulated.values.dtype == precision
    # The answer is rounded once, when it is stored.
    scale = np.abs(exact.accumulated.values).max()
    difference = np.abs(single.accumulated.values - exact.accumulated.values).max()
    assert difference < {"float64": 1e-8, "float32": 1e-6}[precision] * scale


# -- factors --------------------------------------------------------------------------------------


@pytest.fixture
def factorizations(monkeypatch):
    """A list that grows with every matrix that is factorised."""
    calls, original = [], factorization.splu
    monkeypatch.setattr(
        factorization, "splu", lambda matrix: (calls.append(matrix.shape), original(matrix))[1]
    )
    return calls


def test_another_light_in_the_same_grid_needs_no_second_factorization(rng, factorizations):
    stencil = stencil_of("lpv", 2)
    for _ in range(3):
        problem = Problem(stencil, (9, 8), rng)
        found, _ = problem.solve("factorization")
        np.testing.assert_allclose(found, problem.exact(), atol=ERROR)
    assert factorizations == [(216, 216)]


def test_other_walls_need_other_factors(rng, factorizations):
    stencil = stencil_of("lpv", 2)
    for blocked in (0.0, EVERYWHERE, EVERYWHERE):
        problem = Problem(stencil, (9, 8), rng, blocked)
        found, _ = problem.solve("factorization")
        np.testing.assert_allclose(found, problem.exact(), atol=ERROR)
    assert len(factorizations) == 3


def test_factors_at_hand_are_used(rng, factorizations):
    stencil = stencil_of("lpv", 2)
    assert Problem(stencil, (9, 8), rng).solve()[1].method != "factorization"
    Problem(stencil, (9, 8), rng).solve("factorization")
    assert Problem(stencil, (9, 8), rng).solve()[1].method == "factorization"
    assert len(factorizations) == 1


def test_old_factors_are_dropped(rng, factorizations):
    stencil = stencil_of("lpv", 1)
    for side in range(2, 9):
        Problem(stencil, (side, side), rng).solve("factorization")
    assert len(factorization._factors) == factorization._KEPT
    Problem(stencil, (8, 8), rng).solve("factorization")
    assert len(factorizations) == 7
    Problem(stencil, (2, 2), rng).solve("factorization")
    assert len(factorizations) == 8


def test_too_many_unknowns_are_not_factorized(rng, monkeypatch):
    monkeypatch.setattr(factorization, "LARGEST", 100)
    with pytest.raises(InputError, match="at most 100 unknowns, not 216"):
        Problem(stencil_of("lpv", 2), (9, 8), rng).solve("factorization")


# -- clamp ----------------------------------------------------------------------------------------


def test_clamped_scheme_warns_and_gives_its_linear_twin_s_answer():
    clamped = Simulation(scene_of(), propagators.create("lpv", clamp=True))
    with pytest.warns(SchemeWarning, match="not linear") as caught:
        clamped.solve(1e-10)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    linear = Simulation(scene_of(), LPV)
    linear.solve(1e-10)
    np.testing.assert_allclose(clamped.accumulated.values, linear.accumulated.values, atol=1e-8)


def test_linear_scheme_does_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Simulation(scene_of(), LPV).solve()
