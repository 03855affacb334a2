"""Point lights and directional lights: what they and their first bounce put into cells."""

import numpy as np
import pytest

from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics
from flatland.injection import independent_spectra, inject, most_spectra
from flatland.injectors import AreaLight, DirectionalLight, PointLight
from flatland.scene import Scene
from flatland.shadow_map import WEIGHTS
from flatland.sources import ParallelSource, PointSource, SegmentSource

GRID = Grid((24, 20), 0.5, (1.0, -2.0))
BASIS = CircularHarmonics(4)
ROUNDING = 1e-12

POINT = {"kind": "point", "position": (7.13, 4.6), "flux": 10.0}
SUN = {"kind": "directional", "direction": (0.4, -1.0), "irradiance": 1.5}
LAMPS = pytest.mark.parametrize("lamp", [POINT, SUN], ids=["point", "directional"])
SLANTED = {"kind": "segment", "start": (2.0, -0.5), "end": (12.0, 1.1), "albedo": 0.5}
OCCLUDERS = [
    SLANTED,
    {"kind": "segment", "start": (2.0, 6.0), "end": (6.0, 7.3), "albedo": 0.8},
    {
        "kind": "polygon",
        "vertices": ((9.1, 4.0), (11.0, 4.2), (10.6, 6.4), (8.7, 6.0)),
        "albedo": 0.25,
    },
]


def scene_of(*lights, occluders=OCCLUDERS, grid=GRID):
    return Scene.from_dict({"grid": grid, "light": list(lights), "occluder": list(occluders)})


def field_of(*lights, occluders=OCCLUDERS, grid=GRID):
    return inject(scene_of(*lights, occluders=occluders, grid=grid), BASIS)


def bounce(lamp, **keys):
    return {**lamp, "inject": "bounce", **keys}


@LAMPS
@pytest.mark.parametrize("texels", [1, 16, 256])
@pytest.mark.parametrize("occluders", [[SLANTED], OCCLUDERS], ids=["slanted wall", "all"])
def test_first_bounce_is_albedo_times_flux_received(lamp, texels, occluders):
    scene = scene_of(bounce(lamp, texels=texels), occluders=occluders)
    (budget,) = scene.budgets()
    assert budget.received > 0
    if len(occluders) == 1:
        assert budget.reflected == pytest.approx(0.5 * budget.received)
    # Exact at any number of texels: 1e-3 at 256 was asked for.
    assert inject(scene, BASIS).total_flux() == pytest.approx(float(budget.reflected[0]), rel=1e-12)


def test_bounce_of_a_point_light_comes_closer_with_the_square_of_the_texels():
    exact = field_of(bounce(POINT, texels=2**15)).values
    texels = np.array([32, 64, 128, 256, 512])
    errors = []
    for count in texels:
        found = field_of(bounce(POINT, texels=int(count))).values
        errors.append(np.abs(found - exact).sum() / np.abs(exact).sum())
    slope = np.polyfit(np.log(texels), np.log(errors), 1)[0]
    # Flux is spread evenly over a piece: the midpoint rule's order.
    assert 1.6 < -slope < 2.4, f"order {-slope:.2f}, errors {errors}"
    assert errors[3] < 1e-3, f"errors {errors}"


def test_bounce_of_parallel_light_is_exact_at_any_number_of_texels():
    exact = field_of(bounce(SUN, texels=1)).values
    for texels in (7, 256):
        found = field_of(bounce(SUN, texels=texels)).values
        np.testing.assert_allclose(found, exact, atol=ROUNDING)


def test_evenly_lit_wall_is_an_area_light():
    # Light arrives on the left of start -> end.
    wall = {"kind": "segment", "start": (12.0, 1.1), "end": (2.0, -0.5), "albedo": 0.5}
    direction = np.array([0.4, -1.0]) / np.hypot(0.4, 1.0)
    width = abs(10.0 * direction[1] - 1.6 * direction[0])
    area = AreaLight(start=(2.0, -0.5), end=(12.0, 1.1), flux=0.5 * 1.5 * width)
    expected = area.inject(GRID, BASIS) * area.flux
    found = field_of(bounce(SUN), occluders=[wall]).values
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


@LAMPS
def test_lpv2009_is_darker(lamp):
    exact, dark = (field_of(bounce(lamp, weight=w)).total_flux() for w in ("exact", "lpv2009"))
    assert 0.5 * exact < dark < 0.99 * exact


def test_lpv2009_counts_the_cosine_of_a_tilted_wall_twice():
    scenes = [scene_of(bounce(SUN, weight=w), occluders=[SLANTED]) for w in ("exact", "lpv2009")]
    exact, dark = (inject(scene, BASIS).total_flux() for scene in scenes)
    normal, light = np.array([-1.6, 10.0]), np.array([-0.4, 1.0])
    cosine = normal @ light / np.linalg.norm(normal) / np.linalg.norm(light)
    assert dark / exact == pytest.approx(cosine, rel=1e-12)
    # The budget is the lamp's, whatever weight an injector gives it.
    assert scenes[1].budgets()[0].reflected == pytest.approx(float(exact))


@LAMPS
def test_both_is_direct_and_bounce(lamp):
    both, direct, back = (field_of({**lamp, "inject": p}) for p in ("both", "direct", "bounce"))
    np.testing.assert_allclose(both.values, direct.values + back.values, atol=ROUNDING)
    np.testing.assert_array_equal(both.values, field_of(lamp).values)
    assert direct.total_flux() > 0
    assert back.total_flux() > 0


@LAMPS
def test_black_walls_send_nothing_back(lamp):
    black = [{**occluder, "albedo": 0.0} for occluder in OCCLUDERS]
    assert not field_of(bounce(lamp), occluders=black).values.any()
    assert not field_of(bounce(lamp), occluders=[]).values.any()


@pytest.mark.parametrize(
    ("position", "cells"),
    [
        ((7.3, 4.1), [(7, 4)]),
        ((7.0, 4.1), [(6, 4), (7, 4)]),
        ((7.0, 4.0), [(6, 3), (6, 4), (7, 3), (7, 4)]),
        ((7.0 + 1e-12, 4.0), [(6, 3), (6, 4), (7, 3), (7, 4)]),
    ],
)
def test_own_light_of_a_point_is_isotropic_in_the_cells_that_hold_it(position, cells):
    lamp = PointLight(position=tuple(GRID.to_world(position)), flux=3.0)
    field = Field(GRID, BASIS, lamp.inject(GRID, BASIS))
    flux = field.scalar_flux()
    assert [tuple(cell) for cell in np.argwhere(flux)] == cells
    np.testing.assert_allclose(flux[tuple(np.array(cells).T)], 1 / len(cells), rtol=ROUNDING)
    assert not field.values[1:].any()


@pytest.mark.parametrize("direction", [(1.0, 0.0), (-0.6, 0.8), (0.1, -1.0), (-3e-9, -1.0)])
def test_sun_enters_through_each_border_face_with_its_exact_flux(direction):
    lamp = DirectionalLight(direction=direction, irradiance=1.0)
    field = Field(GRID, BASIS, lamp.inject(GRID, BASIS))
    expected, omega = np.zeros(GRID.shape), lamp.heading
    for inward, layer in [((1, 0), 0), ((-1, 0), -1), ((0, 1), 0), ((0, -1), -1)]:
        face = expected[layer] if inward[0] else expected[:, layer]
        face += GRID.spacing * max(0.0, float(np.dot(inward, omega)))
    np.testing.assert_allclose(field.scalar_flux(), expected, atol=ROUNDING)
    net = field.net_flux()
    np.testing.assert_allclose(net, omega[:, None, None] * expected, atol=ROUNDING)
    (budget,) = scene_of(lamp, occluders=[]).budgets()
    assert field.total_flux() == pytest.approx(float(budget.emitted[0]))


def test_sun_does_not_shine_through_a_wall_on_the_border():
    lid = {"kind": "segment", "start": (1.0, 8.0), "end": (7.0, 8.0), "albedo": 0.5}
    down = {"kind": "directional", "direction": (0.0, -1.0), "irradiance": 1.0}
    flux = field_of(down, occluders=[lid]).scalar_flux()
    np.testing.assert_allclose(flux[:12], 0, atol=ROUNDING)  # nor comes anything back from it
    np.testing.assert_allclose(flux[12:, -1], GRID.spacing, rtol=1e-12)


def test_every_colour_bounces_by_its_own_albedo():
    albedos = [(0.5, 0.1, 0.9), (0.2, 0.04, 0.36), (0.0, 1.0, 0.3)]
    coloured = [{**occluder, "albedo": a} for occluder, a in zip(OCCLUDERS, albedos)]
    light = {**POINT, "flux": (10.0, 3.0, 1.0)}
    found = field_of(light, occluders=coloured).values
    for colour, flux in enumerate(light["flux"]):
        grey = [{**o, "albedo": a[colour]} for o, a in zip(OCCLUDERS, albedos)]
        expected = field_of({**POINT, "flux": flux}, occluders=grey).values
        np.testing.assert_allclose(found[colour], expected, atol=ROUNDING)


def test_spectra_of_bounces_are_as_few_as_their_colour_ratios():
    ratios = [(0.5, 0.1, 0.9), (0.25, 0.05, 0.45), (0.5, 0.1, 0.9)]
    for albedos, count in [(ratios, 2), ([0.5, 0.2, 0.1], 1), ([ratios[0], 0.4, (0, 1, 0)], 3)]:
        walls = [{**occluder, "albedo": a} for occluder, a in zip(OCCLUDERS, albedos)]
        scene = scene_of({**POINT, "flux": (10.0, 3.0, 1.0)}, occluders=walls)
        patterns, mixing = independent_spectra(scene, BASIS)
        assert len(patterns) == count <= most_spectra(scene)
        mixed = np.tensordot(mixing, patterns, 1)
        np.testing.assert_allclose(mixed, inject(scene, BASIS).values, atol=1e-11)


@LAMPS
@pytest.mark.parametrize("colours", [0, 3])
def test_twins_carry_the_flux_of_what_is_injected(lamp, colours):
    scale = (1.0, 0.5, 0.0) if colours else 1.0
    key = "flux" if lamp is POINT else "irradiance"
    scene = scene_of({**lamp, key: tuple(lamp[key] * np.array(scale)) if colours else lamp[key]})
    own, walls = scene.sources("direct"), scene.sources("bounce")
    kinds = {type(source) for source in own}
    assert kinds == {PointSource if lamp is POINT else ParallelSource}
    assert {type(source) for source in walls} == {SegmentSource}
    assert len(scene.sources()) == len(own) + len(walls)
    total = np.sum([source.spectrum for source in walls], axis=0)
    np.testing.assert_allclose(total, scene.budgets()[0].reflected, rtol=1e-12)
    np.testing.assert_allclose(own[0].spectrum, lamp[key] * np.atleast_1d(scale))


@LAMPS
def test_a_lamp_that_injects_its_bounce_alone_is_still_known(lamp):
    scene = scene_of(bounce(lamp))
    assert scene.sources("direct") == []
    (source,) = scene.sources("lamp")
    assert isinstance(source, PointSource | ParallelSource)
    assert len(scene.sources("bounce")) == len(scene.sources()) > 10
    direct = scene_of({**lamp, "inject": "direct"})
    assert direct.sources("bounce") == []


def test_twins_of_a_bounce_are_short_pieces_of_walls_that_leave_shadows_dark():
    occluders = [SLANTED, {"kind": "segment", "start": (6.0, 2.0), "end": (7.0, 2.0)}]
    sources = scene_of(bounce(POINT, texels=4096), occluders=occluders).sources()
    ends = np.array([(source.start, source.stop) for source in sources])
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    assert lengths.max() < 0.6 * GRID.spacing
    x = np.sort(ends[..., 0], axis=1)
    gaps = x[np.argsort(x[:, 0])]
    widest = (gaps[1:, 0] - gaps[:-1, 1]).max()
    # The blocker throws its shadow from the lamp onto the slanted wall.
    lamp = np.array(POINT["position"])
    edges = []
    for corner in ((6.0, 2.0), (7.0, 2.0)):
        way = np.array(corner) - lamp
        edges.append(np.linalg.solve(np.array([way, [-10.0, -1.6]]).T, [2.0, -0.5] - lamp))
    shadow = np.abs(np.diff([lamp[0] + t * (c - lamp[0]) for (t, _), c in zip(edges, (6, 7))]))
    assert widest == pytest.approx(shadow[0], rel=1e-9)


def test_lamps_run_in_colour_and_their_books_close():
    from flatland.simulation import Simulation
    from propagators import create

    coloured = [{**occluder, "albedo": (0.5, 0.1, 0.9)} for occluder in OCCLUDERS]
    scene = scene_of({**POINT, "flux": (1.0, 2.0, 0.5)}, SUN, occluders=coloured)
    # Walls that let light pass: the engine adds no bounces of its own.
    simulation = Simulation(scene, create("lpv"), bands=2, blocking="none")
    simulation.run(20)
    expected = sum(budget.emitted + budget.reflected for budget in scene.budgets())
    np.testing.assert_allclose(simulation.ledger.emitted, expected, rtol=1e-12)
    np.testing.assert_allclose(simulation.ledger.closure, 0, atol=1e-10)


def test_every_weight_has_its_choice():
    choices = PointLight.model_fields["weight"].annotation.__args__
    assert set(choices) == set(WEIGHTS)
