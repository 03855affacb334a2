"""A scene on nested grids."""

import numpy as np
import pytest
from scenes import LPV, scene_of

import propagators
from flatland.cascades import Cascade
from flatland.errors import InputError
from flatland.occlusion import Walls
from flatland.scene import Scene
from flatland.simulation import Simulation

ROUNDING = 1e-12
LIGHTS = [
    {"kind": "cell", "cell": [20, 15], "direction": [1.0, 0.4], "flux": 2.0},
    {"kind": "area", "start": [9.0, 20.3], "end": [4.0, 17.0], "flux": 3.0},
    {"kind": "wall", "side": "left", "flux": 4.0},
]
WALLS = [
    {"kind": "segment", "start": [14.0, 10.0], "end": [15.5, 22.0], "albedo": 0.4},
    {"kind": "polygon", "vertices": [[22.0, 20.0], [26.0, 20.0], [26.0, 27.0]], "albedo": 0.8},
]
FLUX = 9.0


def scene(lights=LIGHTS, walls=WALLS, shape=(32, 32)):
    tables = {"grid": {"shape": shape}, "light": lights, "occluder": walls}
    return Scene.from_dict(tables)


def cascade(levels=3, cells=8, focus=(19.0, 17.0), of=None, **options):
    return Cascade(of or scene(), LPV, levels=levels, cells=cells, focus=focus, **options)


@pytest.mark.parametrize("blocking", ["exact", "fuzzy", "none"])
def test_one_grid_over_the_whole_scene_is_a_simulation_bit_for_bit(blocking):
    whole = cascade(1, 32, None, blocking=blocking, bands=3)
    simulation = Simulation(scene(), LPV, bands=3, blocking=blocking)
    whole.run(9)
    simulation.run(9)
    np.testing.assert_array_equal(whole.accumulated(0).values, simulation.accumulated.values)
    np.testing.assert_allclose(
        whole.merge().values, simulation.accumulated.values, rtol=0, atol=1e-15
    )
    assert whole.ledger(0).absorbed == pytest.approx(float(simulation.ledger.absorbed), rel=1e-13)


def test_every_grid_is_a_simulation_of_its_own_cells():
    """Lights of the coarse grid's cells, put there by hand."""
    lights = [
        {"kind": "cell", "cell": cell, "direction": [0.3, 1.0], "flux": flux}
        for cell, flux in (([5, 6], 1.0), ([2, 4], 2.0), ([15, 9], 4.0), ([12, 12], 0.5))
    ]
    run = cascade(2, 8, (8.0, 8.0), scene(lights, (), (16, 16)))
    run.run(7)
    for number, grid in enumerate(run.grids):
        offset = np.array(grid.origin)
        inside = [
            dict(light, cell=place.tolist())
            for light in lights
            for place in [((np.array(light["cell"]) - offset) // 2**number).astype(int)]
            if np.all((place >= 0) & (place < 8))
        ]
        assert len(inside) == (4 if number else 1)
        alone = Simulation(scene_of(inside, (8, 8)), LPV)
        alone.run(7)
        np.testing.assert_allclose(
            run.accumulated(number).values, alone.accumulated.values, atol=1e-15
        )


def test_flux_of_lights_is_injected_or_stated_as_outside():
    run = cascade(blocking="none")
    run.inject()
    outside = run.outside
    for number in range(3):
        ledger = run.ledger(number)
        assert ledger.emitted + outside[number] == pytest.approx(FLUX, rel=1e-14)
    assert outside[2] == pytest.approx(0, abs=1e-15)  # it covers the scene
    assert outside[0] >= outside[1] > 0


def test_books_close_on_every_grid():
    run = cascade(bands=3)
    run.run(12)
    for number in range(3):
        assert abs(run.ledger(number).closure) < ROUNDING
        assert abs(run.ledger(number).created) < ROUNDING
    run.solve(1e-11)
    for number in range(3):
        assert abs(run.ledger(number).closure) < 1e-9
        assert run.ledger(number).inside == 0


@pytest.mark.parametrize("blocking", ["exact", "fuzzy"])
def test_the_finest_grid_meets_the_walls_of_its_part_of_the_scene(blocking):
    run = cascade(blocking=blocking)
    whole = Walls(blocking).occlusion(scene(), run.stencil).transmittance
    first = np.round(run.grids[0].origin).astype(int)
    part = whole[(slice(None), *(slice(n, n + 8) for n in first))]
    found = run._levels[0].occlusion.transmittance
    np.testing.assert_allclose(found, part, atol=1e-12)


def isotropic_sides(dimension, cells):
    """With one band: light of constant radiance from outside, 1/(2D) through every face."""
    sides = ["left", "right", "bottom", "top", "back", "front"][: 2 * dimension]
    flux = cells ** (dimension - 1) / (2 * dimension)
    walls = [{"kind": "wall", "side": s, "flux": flux, "isotropic": True} for s in sides]
    return Scene.from_dict({"grid": {"shape": [cells] * dimension}, "light": walls})


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_uniform_field_is_the_same_at_every_spacing(dimension):
    """Flux through a cell grows like its face, 2^(c(D-1)); a look-up takes that out.

    One band: the walk is then a plain average over neighbours, and 1 W in every cell solves it.
    """
    side = isotropic_sides(dimension, 16)
    uniform = Simulation(side, LPV, bands=1)
    uniform.solve(1e-12)
    np.testing.assert_allclose(uniform.accumulated.scalar_flux(), 1.0, rtol=1e-9)
    for cells in (16, 8, 4):
        levels = {16: 1, 8: 2, 4: 3}[cells]
        run = Cascade(side, LPV, bands=1, levels=levels, cells=cells)
        run.solve(1e-12)
        coarsest = run.accumulated(levels - 1)
        spacing = 2 ** ((levels - 1) * (dimension - 1))
        np.testing.assert_allclose(coarsest.scalar_flux(), spacing, rtol=1e-9)
        # Outside of the finer grids, which get no light from outside (`outside` says so).
        corner = run.look_up(np.full(dimension, 1.0)) * run.basis.flux_weight
        np.testing.assert_allclose(corner, 1.0, rtol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_flux_normalization_of_an_octree_is_exact_for_a_uniform_field(dimension):
    """Factors 2^i in two and in three dimensions, for a random walk as for straight light."""
    levels = 4 if dimension == 2 else 3
    options = {"bands": 1, "levels": levels, "skip": False}
    run = Simulation(isotropic_sides(dimension, 8), LPV, **options)
    run.solve(1e-12)
    for number in range(levels):
        flux = run.level(number).accumulated.scalar_flux()
        np.testing.assert_allclose(flux, 1.0, rtol=1e-9)


class TestLookUp:
    def test_deep_inside_it_is_the_finest_grid(self):
        run = cascade()
        run.run(10)
        grid = run.grids[0]
        centres = grid.to_world(np.moveaxis(np.indices((4, 4)), 0, -1) + 2.5)
        found = run.look_up(centres)
        np.testing.assert_allclose(found, run.accumulated(0).values[:, 2:6, 2:6], atol=1e-15)

    def test_outside_of_it_is_the_next_coarser_grid(self):
        run = cascade(2, 8, (16.0, 16.0))
        run.run(10)
        fine, coarse = run.grids
        centre = coarse.cell_center((1, 4))
        assert not fine.contains(centre)
        expected = run.accumulated(1).values[:, 1, 4] / 2
        np.testing.assert_allclose(run.look_up(centre), expected, atol=1e-15)

    def test_it_is_dark_outside_of_all(self):
        run = cascade(2, 8, (16.0, 16.0))
        run.run(10)
        assert not run.look_up([1.0, 1.0]).any()

    @pytest.mark.parametrize("focus", [(19.0, 17.0), (1.0, 1.0), (31.0, 16.0)], ids=str)
    def test_it_is_continuous_across_all_borders(self, focus):
        run = cascade(of=scene(walls=()), focus=focus)
        run.run(20)
        steps = 4000
        for start, stop in (((0.1, 16.3), (31.9, 17.1)), ((0.2, 0.3), (31.7, 31.8))):
            points = np.linspace(start, stop, steps)
            values = run.look_up(points)
            length = np.hypot(*np.subtract(stop, start)) / steps
            jump = np.abs(np.diff(values, axis=1)).max()
            # The slope of a fade over two cells, at most, and of the field itself.
            assert jump < 3 * length * np.abs(values).max()

    def test_without_fading_it_jumps(self):
        run = cascade(of=scene(walls=()))
        run.run(20)
        points = np.linspace((0.1, 16.3), (31.9, 17.1), 4000)
        jumps = [np.abs(np.diff(run.look_up(points, fade)[0])).max() for fade in (0.0, 2.0)]
        assert jumps[0] > 5 * jumps[1]

    def test_a_merge_is_the_look_up_at_centres(self):
        run = cascade()
        run.run(5)
        field = run.merge()
        assert field.grid == run.scene.grid
        np.testing.assert_allclose(
            field.values[:, 19, 7], run.look_up(run.scene.grid.cell_center((19, 7))), atol=1e-16
        )


def test_colours_are_kept_apart():
    lights = [dict(LIGHTS[0], flux=[1.0, 2.0, 0.0]), dict(LIGHTS[1], flux=[0.5, 1.0, 3.0])]
    run = cascade(of=scene(lights))
    run.run(6)
    for colour in range(3):
        fluxes = [light["flux"][colour] for light in lights]
        mono = cascade(of=scene([dict(x, flux=f) for x, f in zip(lights, fluxes)]))
        mono.run(6)
        for number in range(3):
            found = run.accumulated(number).values[colour]
            np.testing.assert_allclose(found, mono.accumulated(number).values, atol=ROUNDING)
        np.testing.assert_allclose(run.outside[:, colour], mono.outside, atol=ROUNDING)


@pytest.mark.parametrize("name", ["lpv", "dom6", "dom26"])
def test_it_works_in_three_dimensions(name):
    lights = [{"kind": "cell", "cell": [9, 8, 7], "direction": [0.2, 0.1, 1.0], "flux": 1.0}]
    space = scene(lights, (), (16, 16, 16))
    run = Cascade(space, propagators.create(name), levels=2, cells=8)
    run.run(6)
    assert run.ledger(0).emitted == pytest.approx(1.0)
    assert run.ledger(1).emitted == pytest.approx(1.0)
    assert run.merge().values.shape == (4, 16, 16, 16)
    twin = Simulation(space, propagators.create(name))
    twin.run(3)
    # No light has left the finest grid yet.
    again = Cascade(space, propagators.create(name), levels=2, cells=8)
    again.run(3)
    np.testing.assert_allclose(
        again.accumulated(0).values, twin.accumulated.values[:, 4:12, 4:12, 4:12], atol=1e-15
    )


def test_running_in_pieces_and_again():
    pieces, whole = cascade(), cascade()
    for count in (3, 0, 4):
        pieces.run(count)
    whole.solve()
    whole.run(7)
    assert pieces.iteration == whole.iteration == 7
    for number in range(3):
        np.testing.assert_array_equal(
            pieces.accumulated(number).values, whole.accumulated(number).values
        )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda run: run.run(-1), "iterations = -1: must be a whole number"),
        (lambda run: run.accumulated(3), "level = 3: must be a whole number, 0 to 2"),
        (lambda run: run.ledger(True), "level = True: must be a whole number, 0 to 2"),
        (lambda run: run.look_up([1.0]), "points = (1,): must be (..., 2) coordinates"),
        (lambda run: run.merge(-0.5), "fade = -0.5: must be finite and at least 0"),
    ],
)
def test_what_cannot_be_is_refused(call, message):
    with pytest.raises(InputError) as caught:
        call(cascade())
    assert message in str(caught.value)


def test_precisions_that_are_unknown_are_refused():
    with pytest.raises(InputError, match="precision = 'half': is unknown"):
        cascade(precision="half")
    assert cascade(precision="float32").merge().values.dtype == np.float32
