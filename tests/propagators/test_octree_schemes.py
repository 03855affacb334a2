"""Every scheme on levels: books, symmetry, and that levels never make light."""

import numpy as np
import pytest
from scenes import after, quiet, scene_of
from schemes import stencil_classes

import propagators
from flatland.scene import Scene

#: Rounding of some dozen steps.
ROUNDING = 1e-12
WALLS = [
    {"kind": "segment", "start": [4.0, 1.0], "end": [4.4, 6.0], "albedo": 0.3},
    {"kind": "circle", "center": [9.0, 6.0], "radius": 1.5, "albedo": 0.8},
]
LIGHTS_3D = [
    {"kind": "cell", "cell": [2, 3, 1], "direction": [1.0, 0.4, -0.3], "flux": 2.0},
    {"kind": "wall", "side": "left", "flux": 3.0},
]


#: Every scheme of the registry as it comes, where it works, and a clamped one.
SCHEMES = [
    pytest.param(scheme(), dimension, id=f"{scheme.name}-{dimension}D")
    for scheme in stencil_classes()
    for dimension in scheme.dimensions
] + [pytest.param(propagators.create("lpv", clamp=True), 2, id="clamped")]
FLAT = [each for each in SCHEMES if each.values[1] == 2]


def scene_in(dimension, occluders=()):
    scene = scene_of(shape=(12, 9)) if dimension == 2 else scene_of(LIGHTS_3D, (6, 5, 4))
    return Scene.from_dict({**scene.to_dict(), "occluder": list(occluders)})


def _check_books(simulation):
    dimension = simulation.scene.grid.dimension
    emitted = float(simulation.ledger.emitted)
    gain = simulation.stencil.flux_gain
    conserves = np.abs(gain - np.eye(gain.size)[0]).max() < 1e-12 and not simulation.stencil.clamp
    for number in range(simulation.levels):
        view = simulation.level(number)
        ledger, share = view.ledger, simulation.octree.factors[number] / 2 ** (dimension * number)
        assert ledger.emitted == pytest.approx(share * emitted, rel=1e-12)
        assert ledger.emitted <= emitted
        assert abs(ledger.closure) < ROUNDING * emitted
        assert ledger.inside == pytest.approx(float(view.target.total_flux()), abs=ROUNDING)
        if conserves:
            assert abs(ledger.created) < ROUNDING * emitted


@pytest.mark.parametrize(("propagator", "dimension"), SCHEMES)
def test_books_close_on_every_level_and_skipping_cannot_be_seen(propagator, dimension):
    scene, levels = scene_in(dimension), 4 if dimension == 2 else 3
    runs = [after(scene, 3, propagator, levels=levels, skip=skip) for skip in (False, True)]
    np.testing.assert_array_equal(*(run.merge().values for run in runs))
    _check_books(runs[0])


@pytest.mark.parametrize("blocking", ["exact", "fuzzy", "none"])
@pytest.mark.parametrize(("propagator", "dimension"), FLAT)
def test_books_close_among_walls_on_every_level(propagator, dimension, blocking):
    scene = scene_in(2, WALLS)
    simulation = after(scene, 6, propagator, levels=3, blocking=blocking, skip=False)
    _check_books(simulation)
    for number in range(3):
        ledger = simulation.level(number).ledger
        assert (ledger.absorbed > 0) == (blocking != "none")


@pytest.mark.parametrize(("propagator", "dimension"), FLAT)
def test_a_symmetric_scene_keeps_its_symmetry_on_every_level(propagator, dimension):
    """A square of light in the middle: four quarters, down to a single cell."""
    lights = [{"kind": "cell", "cell": [x, y], "flux": 1.0} for x in (3, 4) for y in (3, 4)]
    simulation = after(scene_of(lights, (8, 8)), 3, propagator, bands=3, levels=4, skip=False)
    fields = [simulation.level(number).accumulated for number in range(4)]
    for field in (*fields, simulation.merge(), simulation.merge(blend=1.0)):
        flux = field.scalar_flux()
        tolerance = ROUNDING * np.abs(flux).max()
        for image in (flux.T, flux[::-1], flux[:, ::-1]):
            np.testing.assert_allclose(image, flux, rtol=0, atol=tolerance)


@pytest.mark.parametrize(("name", "dimension"), [("lpv", 2), ("dom8", 2), ("lpv", 3)])
def test_light_superposes_on_levels_where_both_are_read_from_the_same(name, dimension):
    """The index volume belongs to all lights together, so lights are merged together or apart."""
    scheme = propagators.create(name)
    scene = scene_in(dimension)
    whole = after(scene, 4, scheme, levels=3, skip=False)
    apart = [
        after(scene_of([light], scene.grid.shape), 4, scheme, levels=3, skip=False)
        for light in scene.to_dict()["light"]
    ]
    for number in range(3):
        total = sum(run.level(number).accumulated.values for run in apart)
        found = whole.level(number).accumulated.values
        np.testing.assert_allclose(found, total, atol=ROUNDING)


@pytest.mark.parametrize("name", ["lpv", "dom8"])
def test_a_level_of_a_single_cell_sends_all_it_has(name):
    simulation = after(scene_in(2), 3, propagators.create(name), levels=5, skip=False)
    view = simulation.level(4)
    assert view.grid.shape == (1, 1)
    assert view.ledger.left == pytest.approx(float(view.ledger.emitted), rel=1e-14)
    np.testing.assert_array_equal(view.accumulated.values, _injected(simulation))


def _injected(simulation):
    twin = quiet(simulation.propagator, simulation.scene, levels=5)
    twin.start()
    return twin.level(4).target.values
