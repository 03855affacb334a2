"""Converged fields by transforms between mirrors, and unknowns at the border and on walls."""

from collections import OrderedDict

import numpy as np
import pytest
from scenes import scene_of
from schemes import every_scheme
from solving import direct_answer, solved
from stepping import Stepper, neighbours, random_stencil

import propagators
from flatland.errors import InputError, InstabilityError
from flatland.harmonics import CircularHarmonics, basis_for
from flatland.kernels import Layout, Sweep
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.solvers import methods, patches, reduced, solve_converged
from flatland.solvers.edges import Edges
from flatland.solvers.mirrored import Mirrored, mirror_distances
from flatland.solvers.patches import Patches
from flatland.solvers.reduced import Reduced

SHAPES = {2: (17, 12), 3: (7, 6, 5)}


@pytest.fixture(autouse=True, params=[0, patches._ALL], ids=["patches", "cells"])
def nothing_at_hand(request, monkeypatch):
    """With patches of several cells, as on large grids, and with all cells apart."""
    monkeypatch.setattr(methods, "_reduced", OrderedDict())
    monkeypatch.setattr(patches, "_ALL", request.param)


def wall(stencil, shape, rng):
    """τ of a slanted wall that lets a tenth of the light through, and a black bar."""
    transmittance = np.ones((len(stencil.offsets), *shape))
    places = np.indices(shape)
    slanted = np.abs(places[0] - 0.4 * places[1] - 0.3 * shape[0]) < 0.7
    transmittance[:, slanted] = rng.uniform(0, 0.1, transmittance[:, slanted].shape)
    transmittance[0, -2, 1:-1] = 0.0
    return transmittance


@every_scheme(lambda propagator: "clamp=True" not in str(propagator))
def test_every_stable_scheme_is_solved(propagator, dimension, rng):
    stencil = propagator.stencil(basis_for(dimension, 3 if dimension == 2 else 2))
    if stencil.spectral_radius() > 1 + 1e-9:
        pytest.skip("has no converged field")
    shape = SHAPES[dimension]
    tau = wall(stencil, shape, rng)
    light = rng.normal(size=(stencil.basis.size, *shape))
    # Beams that never widen run between mirrors for ever, in most waves: single precision then
    # ends at 1e-9.
    found, report = solved(stencil, shape, light, tau, "mirrored", 1e-8)
    expected = direct_answer(stencil, light, tau)
    assert report.method == "mirrored"
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize(("name", "dimension"), [("lpv", 2), ("dom8", 2), ("lpv", 3), ("dom26", 3)])
def test_open_grids_are_solved(name, dimension, rng):
    stencil = propagators.create(name).stencil(basis_for(dimension, 2))
    shape = SHAPES[dimension]
    light = rng.normal(size=(stencil.basis.size, *shape))
    found, _ = solved(stencil, shape, light, None, "mirrored")
    expected = direct_answer(stencil, light, None)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_it_finds_what_stepping_sums_up(rng):
    stencil = propagators.create("dom8").stencil(CircularHarmonics(3))
    shape = (17, 12)
    light = rng.normal(size=(stencil.basis.size, *shape))
    tau = wall(stencil, shape, rng)
    stepped, _ = solved(stencil, shape, light, tau, "stepping")
    found, _ = solved(stencil, shape, light, tau, "mirrored")
    np.testing.assert_allclose(found, stepped, rtol=0, atol=1e-6 * np.abs(stepped).max())


# -- between mirrors -------------------------------------------------------------------------------


def mirrored_matrix(mirrored, stencil):
    """1 − A on all cells from mirror to mirror, light of the cells outside put by hand."""
    extent = tuple(n + 1 for n in mirrored.periods)
    size = stencil.basis.size
    columns = []
    for k, *cell in np.ndindex(size, *extent):
        field = np.zeros((size, *(n + 2 for n in extent)))
        field[(k, *(np.array(cell) + 1))] = 1.0
        for axis, period in enumerate(mirrored.periods):
            signs = -mirrored.parities[:, axis].reshape(-1, *[1] * (field.ndim - 2))
            moved = np.moveaxis(field, axis + 1, 1)
            moved[:, 0] = signs * moved[:, 2]
            moved[:, period + 2] = signs * moved[:, period]
        inner = (slice(None), *(slice(1, -1) for _ in extent))
        arrived = np.zeros_like(field[inner])
        for offset, transfer in zip(stencil.offsets, stencil.transfer):
            place = tuple(slice(1 - o, 1 - o + n) for o, n in zip(offset, extent))
            arrived += np.tensordot(transfer, field[(slice(None), *place)], 1)
        columns.append((field[inner] - arrived).ravel())
    return np.array(columns).T


@pytest.mark.parametrize(
    ("name", "dimension", "bands", "shape"),
    [("lpv", 2, 3, (4, 6)), ("dom8", 2, 2, (5, 3)), ("lpv", 3, 2, (2, 3, 2))],
)
def test_transforms_invert_the_stencil_between_mirrors(name, dimension, bands, shape, rng):
    stencil = propagators.create(name).stencil(basis_for(dimension, bands))
    mirrored = Mirrored(stencil, shape)
    field = mirrored.field()
    inside = (slice(None), *(slice(1, 1 + n) for n in shape))
    field[inside] = light = rng.normal(size=(stencil.basis.size, *shape))
    found, _ = mirrored.solve(field)
    matrix = mirrored_matrix(mirrored, stencil)
    back = (matrix @ found.ravel()).reshape(found.shape)
    np.testing.assert_allclose(back[inside], light, atol=1e-4)


def test_light_that_runs_between_mirrors_for_ever_is_found():
    """Of DOM, sin 2θ is its own image in both mirrors, and nothing takes it away."""
    assert (
        len(Mirrored(propagators.create("dom8").stencil(CircularHarmonics(2)), (9, 9)).endless) == 0
    )
    assert (
        len(Mirrored(propagators.create("dom8").stencil(CircularHarmonics(3)), (9, 9)).endless) == 1
    )
    assert (
        len(Mirrored(propagators.create("lpv").stencil(CircularHarmonics(3)), (9, 9)).endless) == 0
    )


@pytest.mark.parametrize("cells", [1, 2, 63, 64, 255, 256, 511, 512])
def test_mirrors_are_next_to_the_grid(cells):
    assert mirror_distances((cells,))[0] - cells in (1, 2)


@pytest.mark.parametrize("walls", [False, True], ids=["open", "walls"])
@pytest.mark.parametrize(("name", "bands"), [("lpv", 2), ("dom8", 2), ("dom8", 3)])
def test_patches_of_single_cells_are_the_whole_problem(name, bands, walls, rng, monkeypatch):
    """Every entry of the coarse matrix, from images of one kernel, against transforms."""
    monkeypatch.setattr(patches, "SIDE", 1)
    monkeypatch.setattr(patches, "_LASTING", -1.0)
    stencil = propagators.create(name).stencil(CircularHarmonics(bands))
    shape = (7, 9)
    tau = wall(stencil, shape, rng) if walls else None
    sweep = Sweep(stencil, Layout(shape, stencil.basis.size, np.dtype(float)), tau)
    operator_ = Reduced(sweep)
    fine = Patches(operator_.edges, sweep)
    count = fine.unknowns + operator_.mirrored.endless.shape[0] * stencil.basis.size
    coarse = np.empty((count, count))
    for column in np.eye(count):
        answer = np.empty(count)
        operator_.apply(column, answer)
        back = np.empty(count)
        fine.precondition(answer, back)
        coarse[:, np.flatnonzero(column)[0]] = back
    inner = slice(fine.unknowns)  # endless waves are left to the iteration
    np.testing.assert_allclose(coarse[inner, inner], np.eye(fine.unknowns), atol=2e-4)


def test_edges_are_the_border_and_walls(rng):
    stencil = propagators.create("lpv").stencil(CircularHarmonics(2))
    shape = (12, 10)
    sweep = Sweep(stencil, Layout(shape, 3, np.dtype(float)))
    edges = Edges(sweep, Mirrored(stencil, shape))
    assert len(edges.cells) == 2 * 12 + 2 * 8
    field = edges.mirrored.field()
    field[:, 1:13, 1:11] = rng.normal(size=(3, *shape))
    assert not edges.difference(field).any()  # light inside, none in the mirrors


# -- choice ----------------------------------------------------------------------------------------


def test_a_scheme_that_is_not_its_own_mirror_image_is_refused(rng):
    stencil = random_stencil(rng, CircularHarmonics(1), neighbours(2, diagonal=False))
    stencil = stencil.scaled(0.9 / stencil.spectral_radius())
    light = rng.normal(size=(1, 8, 8))
    with pytest.raises(InputError, match="mirror image"):
        solved(stencil, (8, 8), light, None, "mirrored")
    assert solved(stencil, (8, 8), light, None, "auto")[1].method != "mirrored"


def test_it_is_left_alone_where_memory_is_short(rng, monkeypatch):
    monkeypatch.setattr(reduced, "available_memory", lambda: 1000)
    stencil = propagators.create("dom8").stencil(CircularHarmonics(2))
    light = rng.normal(size=(3, 64, 64))
    assert solved(stencil, (64, 64), light, None, "auto")[1].method != "mirrored"


@pytest.mark.parametrize(
    ("name", "walls", "expected"),
    [("lpv", False, "multigrid"), ("lpv", True, "mirrored"), ("dom8", False, "mirrored")],
)
def test_the_method_is_chosen_by_scheme_and_walls(name, walls, expected, rng):
    stencil = propagators.create(name).stencil(CircularHarmonics(2))
    shape = (64, 64)
    tau = wall(stencil, shape, rng) if walls else None
    light = np.zeros((3, *shape))
    light[0, 20, 9] = 1.0
    assert solved(stencil, shape, light, tau, "auto")[1].method == expected


def test_a_cluttered_grid_is_left_to_bicgstab(rng):
    stencil = propagators.create("dom8").stencil(CircularHarmonics(2))
    light = np.zeros((3, 64, 64))
    light[0, 20, 9] = 1.0
    tau = np.where(rng.random((8, 64, 64)) < 0.1, 0.3, 1.0)
    assert solved(stencil, (64, 64), light, tau, "auto")[1].method == "krylov"


def test_very_many_walls_leave_few_patches(rng, monkeypatch):
    """Cells that are all walled in make no patch together, however large it is."""
    monkeypatch.setattr(patches, "_LEAST", 60)
    monkeypatch.setattr(patches, "_MOST", 60)
    monkeypatch.setattr(patches, "_ALL", 0)
    stencil = propagators.create("lpv").stencil(CircularHarmonics(2))
    light = rng.normal(size=(3, 16, 16))
    tau = rng.uniform(0, 0.4, size=(4, 16, 16))
    operator_ = Reduced(Sweep(stencil, Layout((16, 16), 3, np.dtype(float)), tau))
    assert 0 < operator_.patches.unknowns <= 60
    found, _ = solved(stencil, (16, 16), light, tau, "mirrored")
    expected = direct_answer(stencil, light, tau)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["lpv", "dom4", "dom8"])
def test_with_all_cells_apart_nothing_is_left_to_iterate(name, rng, monkeypatch):
    monkeypatch.setattr(patches, "_ALL", 3600)
    stencil = propagators.create(name).stencil(CircularHarmonics(2))
    light = rng.normal(size=(3, 24, 30))
    _, report = solved(stencil, (24, 30), light, wall(stencil, (24, 30), rng), "mirrored")
    assert report.residual <= 1e-9
    assert report.iterations <= 6


def test_set_up_is_kept_for_other_lights_and_not_for_other_walls(rng):
    stencil = propagators.create("lpv").stencil(CircularHarmonics(2))
    light = rng.normal(size=(3, 16, 16))
    tau = wall(stencil, (16, 16), rng)
    first, _ = solved(stencil, (16, 16), light, tau, "mirrored")
    again, _ = solved(stencil, (16, 16), 2 * light, tau.copy(), "mirrored")
    assert len(methods._reduced) == 1
    np.testing.assert_allclose(again, 2 * first, atol=1e-6 * np.abs(first).max())
    tau[0, 5] = 0.5
    other, _ = solved(stencil, (16, 16), light, tau, "mirrored")
    assert len(methods._reduced) == 2
    assert np.abs(other - first).max() > 1e-3 * np.abs(first).max()


def test_applications_hardly_grow_with_the_grid(rng):
    for name, limit in (("lpv", 15), ("dom8", 32)):
        stencil = propagators.create(name).stencil(CircularHarmonics(2))
        for cells in (32, 96):
            light = np.zeros((3, cells, cells))
            light[0, cells // 3, 3] = 1.0
            _, report = solved(stencil, (cells, cells), light, None, "mirrored", 1e-8)
            assert report.applications <= limit, (name, cells)


# -- from the last answer --------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["mirrored", "multigrid", "stepping"])
def test_the_same_light_goes_on_from_its_answer(method, rng):
    stencil = propagators.create("lpv").stencil(CircularHarmonics(2))
    stepper = Stepper(stencil, (24, 20), None)
    right, answer = stepper.buffer(rng.normal(size=(3, 24, 20))), stepper.buffer()

    def solve(light, tolerance):
        return solve_converged(stepper.sweep, light, answer, tolerance, method)

    first = solve(right, 1e-4)
    assert solve(right, 1e-4).iterations == 0
    more = solve(right, 1e-8)
    assert more.residual <= 1e-8
    assert solve(3 * right, 1e-8).iterations == 0
    expected, fresh = solved(stencil, (24, 20), stepper.layout.view(right), None, method, 1e-8)
    np.testing.assert_allclose(stepper.layout.view(answer), 3 * expected, rtol=0, atol=1e-4)
    assert more.applications < fresh.applications
    elsewhere = solve(stepper.buffer(rng.normal(size=(3, 24, 20))), 1e-4)
    assert elsewhere.iterations >= first.iterations


# -- walls that make light grow -----------------------------------------------------------------


def loose_white_walls(seed, cell=(5, 5)):
    rng, cells = np.random.default_rng(seed), 24
    walls = []
    for _ in range(12):
        middle, angle = rng.uniform(2, cells - 2, 2), rng.uniform(0, np.pi)
        half = rng.uniform(2, 5) * np.array([np.cos(angle), np.sin(angle)])
        ends = {"start": list(middle - half), "end": list(middle + half)}
        walls.append({"kind": "segment", "albedo": 1.0, **ends})
    light = {"kind": "cell", "cell": list(cell), "direction": [1.0, 0.3], "flux": 2.0}
    return Scene.from_dict({"grid": {"shape": [24, 24]}, "light": [light], "occluder": walls})


@pytest.mark.parametrize("method", ["auto", "multigrid", "mirrored", "factorization"])
def test_light_that_grows_among_walls_has_no_converged_field(method):
    """The radius is 1.0709 there, by the eigenvalues of the whole matrix: in a cell that walls seal
    off."""
    run = Simulation(loose_white_walls(1, (9, 19)), propagators.create("lpv-2009"), bands=2)
    with pytest.raises(InstabilityError, match="by a factor 1.070"):
        run.solve(1e-8, method)


@pytest.mark.parametrize("method", ["auto", "mirrored", "factorization"])
@pytest.mark.parametrize("seed", [1, 8, 18])
def test_sealed_rooms_stay_dark(seed, method):
    """Light outside never gets to where it would grow, nor does the residual of a solver."""
    run = Simulation(loose_white_walls(seed), propagators.create("lpv-2009"), bands=2)
    run.run(1500)
    stepped = run.accumulated.values
    run.solve(1e-9, method)
    found = run.accumulated.values
    np.testing.assert_allclose(found, stepped, rtol=0, atol=1e-6 * np.abs(stepped).max())
    dark = ~np.any(stepped, axis=0)
    assert dark.any()
    assert not found[:, dark].any()


def test_negative_light_that_dies_out_is_an_answer():
    run = Simulation(loose_white_walls(0), propagators.create("dom8"), bands=2)
    run.solve(1e-9)
    assert abs(run.ledger.closure) < 1e-6


def test_ledger_closes(rng):
    run = Simulation(scene_of(), propagators.create("dom8"), bands=3)
    run.solve(1e-11, "mirrored")
    assert run.ledger.inside == 0
    assert abs(run.ledger.closure) < 1e-10
