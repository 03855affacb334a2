"""Schemes that answer at once, in a homogeneous medium: against photons and against each other."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene, random_scene
from montecarlo import share_that_leaves
from tabulated import error, exact, one_light

import propagators
from flatland.errors import InputError, SchemeWarning
from flatland.moments import exact_moments
from flatland.scene import Scene
from propagators.beam.solution import first_flight_through
from propagators.maps.flight import Maps
from propagators.maps.generations import settled_light
from propagators.maps.propagator import LightPropagationMaps
from propagators.modified_dom import ModifiedDiscreteOrdinates
from propagators.transport.ordinates import Ordinates
from propagators.transport.problem import read_problem

CLOSED = 1e-12
SCHEMES = [
    name
    for name in propagators.names()
    if issubclass(propagators.find(name), propagators.DirectPropagator)
    and propagators.find(name).media
]
every_scheme_of_media = pytest.mark.parametrize("name", SCHEMES)
quiet = pytest.mark.filterwarnings("ignore::flatland.errors.SchemeWarning")


def filled(scene, extinction, albedo):
    return Scene.from_dict(
        {**scene.to_dict(), "medium": {"extinction": extinction, "albedo": albedo}}
    )


def scaled(factor, albedo=0.5):
    lights = [(factor * np.array(a), factor * np.array(b), flux) for a, b, flux in LIGHTS]
    walls = [(factor * np.array(a), factor * np.array(b)) for a, b in WALLS]
    return make_scene((8 * factor, 8 * factor), lights, walls, albedo=albedo)


def flown(scene, count=512):
    """First flight by beams, and the problem."""
    problem = read_problem(scene, 3, 0.5, True)
    return problem, first_flight_through(problem, Ordinates(count))


@every_scheme_of_media
@quiet
@pytest.mark.parametrize(("extinction", "albedo"), [(0.05, 0.9), (0.7, 0.4), (1.2, 1.0)])
def test_books_close(name, extinction, albedo):
    lights = [(*LIGHTS[0][:2], [3.0, 1.0]), (*LIGHTS[1][:2], [0.0, 2.0])]
    point = {"kind": "point", "position": [4.2, 5.7], "flux": [1.0, 0.5]}
    sun = {"kind": "directional", "direction": [1.0, -0.6], "irradiance": 0.2}
    for scene in (
        make_scene(albedo=0.6),
        make_scene(lights=lights, albedo=[0.3, 0.8], points=[point]),
        make_scene(lights=(), walls=WALLS[:2], points=[sun]),
    ):
        answer = propagators.create(name).answer(filled(scene, extinction, albedo), 2)
        ledger = answer.ledger
        np.testing.assert_allclose(ledger.closure, 0, atol=CLOSED)
        assert np.all(np.abs(ledger.inside) < 1e-8)
        assert np.all((ledger.medium > 1e-3) == (albedo < 1))
        assert np.all(ledger.absorbed > 0)
        assert np.all(np.isfinite(answer.field.values))


@every_scheme_of_media
def test_no_extinction_is_a_vacuum_bit_for_bit(name):
    for scene in (make_scene(albedo=0.5), one_light()):
        plain = propagators.create(name).answer(scene, 2)
        empty = propagators.create(name).answer(filled(scene, 0.0, 0.9), 2)
        np.testing.assert_array_equal(plain.field.values, empty.field.values)
        assert plain.ledger.as_dict() == empty.ledger.as_dict()


@every_scheme_of_media
@quiet
def test_the_thinnest_medium_is_a_vacuum_and_opaque_ones_are_refused(name):
    scene = make_scene(albedo=0.5)
    thin = propagators.create(name).answer(filled(scene, 1e-300, 0.9), 2)
    assert np.all(np.isfinite(thin.field.values))
    assert thin.ledger.medium < 1e-15
    assert abs(thin.ledger.closure) < CLOSED
    with pytest.raises(InputError, match="medium, extinction"):
        propagators.create(name).answer(filled(scene, 1e4, 0.9), 2)


@every_scheme_of_media
@quiet
def test_collisions_go_by_metres(name):
    """Twice as much of the medium in cells half as wide."""
    tables = make_scene(albedo=0.5).to_dict()
    tables["grid"] = {**tables["grid"], "spacing": 0.5}
    for item in (*tables["light"], *tables["occluder"]):
        item |= {key: [0.5 * x for x in item[key]] for key in ("start", "end")}
    small = filled(Scene.from_dict(tables), 1.2, 0.8)
    np.testing.assert_allclose(
        propagators.create(name).solve(small, 2).values,
        propagators.create(name).solve(filled(make_scene(albedo=0.5), 0.6, 0.8), 2).values,
        rtol=0,
        atol=1e-12,
    )


# -- first flight by beams ----------------------------------------------------------------------


@pytest.mark.parametrize("extinction", [1e-7, 0.1, 1.0, 5.0])
def test_beams_fade_as_rays_do(extinction):
    """Whole beams against many rays: the field, and what collides in every cell."""
    for scene in (make_scene(), random_scene(5, step=1.0)):
        problem, beams = flown(filled(scene, extinction, 0.0), 256)
        rays = Maps(problem, 64, 16).run(np.zeros((problem.surfaces.count, 2, 1)))
        values = np.moveaxis(rays.cells, 2, 0)[None]
        assert error(beams.values, values) < (0.01 if extinction < 2 else 0.04)
        assert error(beams.collided[0], rays.collided[:, :, 0]) < 0.01
        assert beams.collided.min() > -1e-14
        assert beams.left[0] == pytest.approx(rays.left[0], abs=4e-3)


def test_beams_that_hardly_fade_are_those_of_a_vacuum():
    scene = make_scene()
    _, beams = flown(filled(scene, 1e-9, 0.5), 1024)
    assert error(beams.values[0], exact(scene, 3)) < 2e-5


def test_intensities_by_direction_are_refused():
    with pytest.raises(InputError, match="extinction = 0.5: fills the grid, and intensities by"):
        propagators.create("beam").intensity(filled(one_light(), 0.5, 0.5), [[1.0, 0.0]])


def test_what_leaves_an_empty_grid_by_quadrature():
    """∫ dx ∫ cos θ/2 e^(-σ d) dθ of a light along x, d the way to the border."""
    sigma, size, low, high = 0.4, 6.0, 1.5, 4.0
    scene = make_scene((6, 6), [((low, 2.0), (high, 2.0), 1.0)], ())
    _, beams = flown(filled(scene, sigma, 0.0), 4096)
    node, weight = np.polynomial.legendre.leggauss(60)
    x = 0.5 * (low + high) + 0.5 * (high - low) * node
    angle = (np.arange(20000) + 0.5) * (np.pi / 20000)
    with np.errstate(divide="ignore"):
        to_side = np.where(np.cos(angle) > 0, size - x[:, None], -x[:, None]) / np.cos(angle)
    way = np.minimum((size - 2.0) / np.sin(angle), to_side)
    leaves = 0.5 * (np.sin(angle) * np.exp(-sigma * way)).sum(axis=1) * (np.pi / 20000)
    assert beams.left[0] == pytest.approx(0.5 * weight @ leaves, rel=1e-5)


@pytest.mark.parametrize("extinction", [0.3, 3.0])
def test_mirrored_beams_fade_in_the_mirror(extinction):
    lights, walls = [((2.0, 1.0), (5.0, 1.0), 1.0)], [((1.0, 4.0), (3.5, 5.0))]
    _, left = flown(filled(make_scene(lights=lights, walls=walls), extinction, 0.0), 64)
    lights, walls = [((3.0, 1.0), (6.0, 1.0), 1.0)], [((7.0, 4.0), (4.5, 5.0))]
    _, right = flown(filled(make_scene(lights=lights, walls=walls), extinction, 0.0), 64)
    np.testing.assert_allclose(left.collided, right.collided[:, ::-1], rtol=0, atol=1e-13)


# -- scattering ---------------------------------------------------------------------------------


@quiet
@pytest.mark.parametrize(("extinction", "albedo"), [(0.1, 0.9), (0.3, 0.5), (0.5, 1.0)])
@pytest.mark.parametrize("name", ["beam", "light-propagation-maps"])
def test_what_leaves_is_that_of_photons(name, extinction, albedo):
    share, deviation = share_that_leaves(LIGHTS, WALLS, 0.5, 300_000, 2, (extinction, albedo), 8.0)
    left = [
        propagators.create(name).answer(filled(scaled(f), extinction / f, albedo), 1).ledger.left
        / 5
        for f in (1, 3)
    ]
    # Scattering from whole cells lets light out a little easier; it vanishes with the cell.
    assert abs(left[1] - share) < 0.35 * abs(left[0] - share) + 4 * deviation
    assert left[1] == pytest.approx(share, rel=0.02)


@quiet
@pytest.mark.parametrize("albedo", [0.0, 0.5])
@pytest.mark.parametrize(
    ("optical", "size", "expected"), [(0.5, 73, 1.039), (1.0, 41, 1.147), (2.0, 21, 1.519)]
)
def test_maps_spread_light_too_far_by_the_size_of_a_cell(optical, size, expected, albedo):
    scene = Scene.from_dict(
        {
            "grid": {"shape": [size, size]},
            "light": [{"kind": "cell", "cell": [size // 2, size // 2], "flux": 1.0}],
            "medium": {"extinction": optical, "albedo": albedo},
        }
    )
    scheme = LightPropagationMaps(source="cell", angles=8, rays=8)
    maps, _, cells = scheme._sources(read_problem(scene, 1, 0.5, True))
    met = settled_light(maps, cells, maps.problem.sizeless_flux).tally.collided[:, :, 0]
    place = np.arange(size) - size // 2
    truth = exact_moments(optical, albedo)
    assert met.sum() == pytest.approx(truth.m0, rel=1e-3)
    square = np.sum(met * (place[:, None] ** 2 + place**2))
    # A black medium lets a few photons out of the grid.
    assert square / truth.r2 == pytest.approx(expected, rel=0.004)
    assert expected <= 1 + optical**2 / 6


@quiet
def test_beams_and_maps_agree_on_scattered_light():
    scene = filled(scaled(2), 0.15, 0.9)
    beams = propagators.create("beam", ordinates=256).answer(scene, 3)
    maps = propagators.create("light-propagation-maps", angles=32, rays=8).answer(scene, 3)
    assert error(beams.field.values, maps.field.values) < 0.015
    assert beams.ledger.medium == pytest.approx(maps.ledger.medium, rel=1e-3)


@quiet
def test_a_first_flight_of_its_own_helps_a_stencil():
    scene = filled(scaled(2), 0.15, 0.9)
    truth = propagators.create("beam", ordinates=256).solve(scene, 3).values
    for scheme in ("dom8", "lpv"):
        alone = error(propagators.create(scheme).solve(scene, 3).values, truth)
        together = ModifiedDiscreteOrdinates(scheme=scheme).solve(scene, 3).values
        assert error(together, truth) < 0.5 * alone


@quiet
def test_lattice_diffuses_like_maps_in_a_cloud():
    """Far from lights and walls all that is left is diffusion."""
    light = {"kind": "cell", "cell": [10, 10], "flux": 1.0}
    scene = Scene.from_dict({"grid": {"shape": [21, 21]}, "light": [light]})
    cloud = filled(scene, 0.9, 0.98)
    lattice = propagators.create("lattice-boltzmann").answer(cloud, 1)
    maps = propagators.create("light-propagation-maps", source="cell", angles=8, rays=4)
    flown = maps.answer(cloud, 1)
    assert lattice.ledger.medium == pytest.approx(flown.ledger.medium, rel=0.06)
    # The lattice's own light, eight streets wide, is gone a few cells away.
    far = np.hypot(*(np.indices((21, 21)) - 10.0)) > 4
    assert error(lattice.field.scalar_flux()[far], flown.field.scalar_flux()[far]) < 0.15


def test_thick_cells_are_warned_of_with_the_number():
    rule = r"of 1 collisions a cell, scattering from whole cells spreads light over up to 116.7%"
    with pytest.warns(SchemeWarning, match=rule):
        propagators.create("light-propagation-maps", angles=4, rays=1).solve(
            filled(one_light(), 1.0, 0.5), 1
        )
