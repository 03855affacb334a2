"""Stencils in a homogeneous medium: where collisions are put, how far light spreads, the books."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from scenes import LIGHTS, SHAPE, after
from schemes import every_scheme, is_linear

import propagators
from flatland.errors import InputError, SchemeWarning
from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.medium import Medium, collision_probability, share_ahead
from flatland.medium_step import in_medium
from flatland.moments import exact_moments, moments_of, spread_ratio, step_moments
from flatland.scene import Scene, SceneError, parse_scene, scene_to_toml
from flatland.simulation import Simulation

ROUNDING = 1e-12
OPTICAL = (0.1, 0.5, 1.0, 2.0)
WALLS = [
    {"kind": "segment", "start": [2.0, 5.3], "end": [7.0, 4.8], "albedo": 0.6},
    {"kind": "segment", "start": [6.0, 1.0], "end": [6.5, 3.8]},
]


def medium_scene(extinction, albedo, walls=(), lights=LIGHTS, shape=SHAPE, spacing=1.0):
    return Scene.from_dict(
        {
            "grid": {"shape": shape, "spacing": spacing},
            "light": lights,
            "occluder": list(walls),
            "medium": {"extinction": extinction, "albedo": albedo},
        }
    )


def step(name, bands, optical, albedo=0.9, share="moment", length="centre", **options):
    stencil = propagators.create(name, **options).stencil(basis_for(2, bands))
    return in_medium(stencil, Medium(optical, albedo), Grid((4, 4)), share, length)


# -- where collisions are put -------------------------------------------------------------------


def test_shares_by_number():
    found = share_ahead([0.1, 0.5, 1, 2, 4])
    expected = [0.4833430, 0.417855, 0.342258, 0.224279, 0.101846]
    np.testing.assert_allclose(found, expected, rtol=0, atol=6e-7)


@pytest.mark.parametrize("x", ["1e-9", "0.001", "0.1", "0.1999", "0.2", "0.2001", "1", "20"])
def test_shares_to_the_last_digits(x):
    with localcontext() as context:
        context.prec = 60
        exact = Decimal(x)
        p = 1 - (-exact).exp()
        moment = 1 - ((2 - p) / p**2 - 2 / exact**2) / (2 / p - 1)
        linear = 1 / exact - (1 - p) / p
    assert share_ahead(float(x)) == pytest.approx(float(moment), rel=1e-12)
    assert share_ahead(float(x), "linear") == pytest.approx(float(linear), rel=1e-12)


@pytest.mark.parametrize("x", [0.05, 0.3, 1.0, 5.0])
def test_shares_keep_what_they_are_named_for(x):
    """A flight of whole steps that collides on step k ends at k with b, else at k - 1."""
    k = np.arange(1, 4000)
    p = float(collision_probability(x))
    chance = p * (1 - p) ** (k - 1)
    b = float(share_ahead(x))
    square = chance @ (b * k**2 + (1 - b) * (k - 1) ** 2)
    assert square * x**2 == pytest.approx(2, rel=1e-10)
    b = float(share_ahead(x, "linear"))
    assert (chance @ (b * k + (1 - b) * (k - 1))) * x == pytest.approx(1, rel=1e-10)


def test_unknown_rules_are_refused():
    with pytest.raises(InputError, match="share = 'middle': is unknown"):
        share_ahead(1.0, "middle")
    with pytest.raises(InputError, match="step_length = 'edge': is unknown"):
        step("dom4", 2, 1.0, length="edge")


# -- how far light spreads ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "bands", "expected"),
    [
        ("dom8", 16, (0.9858, 0.9894, 0.9930, 0.9971)),
        ("dom8", 8, (0.9707, 0.9782, 0.9856, 0.9941)),
        ("dom8", 4, (0.9532, 0.9641, 0.9755, 0.9895)),
        ("dom8", 2, (0.9528, 0.9643, 0.9750, 0.9870)),
        ("dom4", 8, (0.9521, 0.9619, 0.9729, 0.9880)),
        ("dom8", 1, (0.0619, 0.2982, 0.5421, 0.8277)),
        ("lpv", 2, (0.1028, 0.3750, 0.5860, 0.8262)),
        ("lpv", 4, (0.1028, 0.3750, 0.5860, 0.8262)),
    ],
)
@pytest.mark.parametrize("albedo", [0.0, 0.9])
def test_mean_square_distance_as_tabulated(name, bands, expected, albedo):
    for optical, ratio in zip(OPTICAL, expected):
        found, truth = (
            step_moments(step(name, bands, optical, albedo)),
            exact_moments(optical, albedo),
        )
        assert found.m0 == pytest.approx(truth.m0, rel=1e-12)
        assert found.r2 / truth.r2 == pytest.approx(ratio, abs=6e-5), optical
        assert spread_ratio(step(name, bands, optical, albedo)) == pytest.approx(ratio, abs=6e-5)


@pytest.mark.parametrize("albedo", [0.0, 0.9])
def test_eight_streets_of_their_own_have_the_exact_mean_square(albedo):
    """DOM8 with a flux for each street instead of harmonics: only bands lose anything."""
    streets = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)])
    fourth = {0.0: (1.0, 1.0006, 1.0097, 1.1291), 0.9: (1.0, 1.0001, 1.0014, 1.0184)}
    for optical, r4 in zip(OPTICAL, fourth[albedo]):
        x = Medium(optical, albedo).optical_lengths(streets, 1.0)
        p, b = collision_probability(x), share_ahead(x)

        def response(waves, p=p, b=b):
            phase = np.exp(-1j * (waves @ streets.T))
            received = p * (1 - b + b * phase)
            passing = np.einsum("mk,kj->mkj", (1 - p) * phase, np.eye(8))
            scattered = np.einsum("k,mj->mkj", np.full(8, albedo / 8), received)
            sent = np.linalg.solve(
                np.eye(8) - passing - scattered, np.full((len(waves), 8, 1), 1 / 8, complex)
            )
            return np.einsum("mk,mk->m", received, sent[:, :, 0])

        truth = exact_moments(optical, albedo)
        found = moments_of(response, 0.1 * (1 - albedo) * optical)
        assert found.m0 == pytest.approx(truth.m0, rel=1e-12)
        assert found.r2 == pytest.approx(truth.r2, rel=1e-8)
        assert found.r4 / truth.r4 == pytest.approx(r4, abs=6e-5)


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        ("linear", (0.972, 1.009, 1.107, 1.446)),
        ("half", (0.973, 1.041, 1.244, 2.123)),
        ("ahead", (1.032, 1.347, 1.919, 3.902)),
    ],
)
def test_other_shares_as_tabulated(share, expected):
    for optical, ratio in zip(OPTICAL, expected):
        found = step_moments(step("dom8", 8, optical, share=share))
        assert found.r2 / exact_moments(optical, 0.9).r2 == pytest.approx(ratio, abs=6e-4)


def test_lpv_with_chords_as_tabulated():
    for optical, ratio in zip(OPTICAL, (0.134, 0.512, 0.820, 1.208)):
        found = step_moments(step("lpv", 2, optical, length="chord"))
        assert found.r2 / exact_moments(optical, 0.9).r2 == pytest.approx(ratio, abs=6e-4)


@pytest.mark.parametrize(("name", "bands"), [("lpv", 2), ("lpv", 4), ("dom4", 4), ("dom8", 5)])
@pytest.mark.parametrize("optical", [0.1, 1.0])
def test_scattering_without_loss_neither_grows_nor_fades(name, bands, optical):
    axis = np.linspace(-np.pi, np.pi, 25)
    waves = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    radii = np.abs(np.linalg.eigvals(step(name, bands, optical, 1.0).symbol(waves)))
    assert radii.max() == pytest.approx(1, abs=1e-12)


def test_a_medium_does_not_make_dom8_with_peaks_stable():
    """1.2732 in a vacuum."""
    axis = np.linspace(-np.pi, np.pi, 25)
    waves = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    thin = step("dom8", 5, 0.1, 0.5, emission="delta")
    assert np.abs(np.linalg.eigvals(thin.symbol(waves))).max() == pytest.approx(1.1287, abs=0.02)


def test_exact_moments_are_those_of_photons(rng):
    """Flights of exponential length in random directions, scattered with the share c."""
    sigma, albedo, count = 0.7, 0.6, 200_000
    place, alive = np.zeros((count, 2)), np.ones(count, bool)
    m0 = r2 = r4 = 0.0
    while alive.any():
        turn = rng.uniform(0, 2 * np.pi, alive.sum())
        length = rng.exponential(1 / sigma, alive.sum())
        place[alive] += length[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        square = (place[alive] ** 2).sum(axis=1)
        m0, r2, r4 = m0 + len(square), r2 + square.sum(), r4 + (square**2).sum()
        alive[alive] = rng.random(alive.sum()) < albedo
    truth = exact_moments(sigma, albedo)
    assert m0 / count == pytest.approx(truth.m0, rel=0.01)
    assert r2 / count == pytest.approx(truth.r2, rel=0.02)
    assert r4 / count == pytest.approx(truth.r4, rel=0.1)


@pytest.mark.parametrize("name", ["lpv", "dom8"])
def test_the_ratio_is_sound_in_the_thinnest_and_the_thickest_media(name):
    """In thin media DOM8's is one of bands, LPV's falls with the medium; in thick ones it is 1."""
    thin = 0.949644 if name == "dom8" else 1.1549e-4
    for optical in (1e-300, 1e-12, 1e-5):
        assert spread_ratio(step(name, 2, optical)) == pytest.approx(thin, rel=1e-3)
    for optical in (30.0, 100.0, 400.0):
        assert spread_ratio(step(name, 2, optical)) == pytest.approx(1, abs=2e-3)
        found, truth = step_moments(step(name, 2, optical)), exact_moments(optical, 0.9)
        assert found.m0 == pytest.approx(truth.m0, rel=1e-9)
        assert found.r2 == pytest.approx(truth.r2, rel=2e-3)


# -- the simulation ---------------------------------------------------------------------------


@every_scheme(is_linear, dimensions=(2,))
@pytest.mark.parametrize("walls", [(), WALLS], ids=["open", "walls"])
def test_books_close_for_every_scheme(propagator, dimension, walls):
    ledger = after(medium_scene(0.8, 0.7, walls), 17, propagator, bands=3).ledger
    assert abs(ledger.closure) < ROUNDING
    assert ledger.medium > 0.1
    assert (abs(ledger.absorbed) > 0.01) == bool(walls)
    vacuum = after(medium_scene(0, 0, walls), 17, propagator, bands=3).ledger
    assert ledger.created == pytest.approx(0, abs=1e-9) or vacuum.created != 0
    assert vacuum.medium == 0


@pytest.mark.parametrize("name", ["dom4", "dom8", "lpv"])
@pytest.mark.filterwarnings("ignore::flatland.errors.SchemeWarning")
def test_converged_books_are_those_of_many_steps(name):
    scene = medium_scene(0.4, 0.9, WALLS)
    simulation = Simulation(scene, propagators.create(name), bands=2)
    simulation.solve(1e-12)
    found, stepped = simulation.ledger, after(scene, 2000, propagators.create(name), bands=2).ledger
    for entry in ("emitted", "left", "absorbed", "medium", "reflected"):
        assert getattr(found, entry) == pytest.approx(getattr(stepped, entry), rel=1e-9)
    assert abs(found.closure) < 1e-10


@pytest.mark.parametrize("name", ["dom4", "dom8", "lpv"])
@pytest.mark.parametrize("walls", [(), WALLS], ids=["open", "walls"])
def test_no_extinction_is_a_vacuum_bit_for_bit(name, walls):
    tables = {"grid": {"shape": SHAPE}, "light": LIGHTS, "occluder": list(walls)}
    plain = after(Scene.from_dict(tables), 20, propagators.create(name), bands=3)
    filled = after(medium_scene(0.0, 0.7, walls), 20, propagators.create(name), bands=3)
    np.testing.assert_array_equal(plain.accumulated.values, filled.accumulated.values)
    assert plain.ledger.as_dict() == filled.ledger.as_dict()


@pytest.mark.parametrize("name", ["dom4", "lpv"])
@pytest.mark.filterwarnings("ignore::flatland.errors.SchemeWarning")
def test_light_fades_exponentially_in_a_black_medium(name):
    """All steps of an axial scheme are h long."""
    lights = [{"kind": "cell", "cell": [10, 10], "direction": [1.0, 0.0], "flux": 3.0}]
    scene = medium_scene(0.5, 0.0, lights=lights, shape=(21, 21), spacing=0.6)
    for count in (1, 4, 9):
        ledger = after(scene, count, propagators.create(name), bands=4).ledger
        assert ledger.inside == pytest.approx(3 * np.exp(-0.3 * count), rel=1e-13)
        assert ledger.medium + ledger.left + ledger.inside == pytest.approx(3, abs=ROUNDING)


@pytest.mark.filterwarnings("ignore::flatland.errors.SchemeWarning")
def test_collisions_in_cells_add_up_to_what_is_absorbed():
    scene = medium_scene(0.7, 0.6, WALLS)
    simulation = after(scene, 30, propagators.create("dom8"), bands=3)
    sent = simulation.accumulated.values - simulation.target.values
    level = simulation.octree.levels[0]
    collided = level.medium.collided(sent, level.occlusion)
    # What collides a step beyond the border is absorbed as well, if not scattered.
    assert (1 - 0.6) * collided.sum() == pytest.approx(simulation.ledger.medium, rel=0.05)
    assert (1 - 0.6) * collided.sum() <= simulation.ledger.medium
    assert np.all(collided >= -1e-3)


def test_thin_media_are_warned_of_with_the_number():
    rule = r"with 2 bands spreads light over .* over 37.5% of it at 0.5 collisions a cell$"
    with pytest.warns(SchemeWarning, match=rule):
        Simulation(medium_scene(0.5, 0.9), propagators.create("lpv"), bands=2)
    Simulation(medium_scene(0.5, 0.9), propagators.create("dom8"), bands=2)
    Simulation(medium_scene(4.0, 0.9), propagators.create("lpv"), bands=2)


def test_what_cannot_be_done_in_a_medium_is_refused():
    with pytest.raises(InputError, match="clamp = True: knows no medium"):
        Simulation(medium_scene(4.0, 0.5), propagators.create("lpv", clamp=True))
    with pytest.raises(InputError, match="blocking = 'fuzzy': cannot be read in a medium"):
        Simulation(medium_scene(4.0, 0.5, WALLS), propagators.create("lpv"), blocking="fuzzy")
    with pytest.raises(InputError, match=r"extinction = 700.0: leaves e\^-990 of the light"):
        Simulation(medium_scene(700.0, 0.5), propagators.create("dom8"))


@pytest.mark.filterwarnings("ignore::flatland.errors.SchemeWarning")
def test_colours_and_single_precision():
    lights = [dict(LIGHTS[0], flux=[2.0, 0.5]), dict(LIGHTS[3], flux=[0.0, 1.5])]
    scene = medium_scene(0.6, 0.8, WALLS, lights)
    double = after(scene, 30, propagators.create("dom8"), bands=2)
    np.testing.assert_allclose(double.ledger.closure, 0, atol=ROUNDING)
    for k in range(2):
        grey = [dict(light, flux=light["flux"][k]) for light in lights]
        one = after(medium_scene(0.6, 0.8, WALLS, grey), 30, propagators.create("dom8"), bands=2)
        assert double.ledger.medium[k] == pytest.approx(one.ledger.medium, rel=1e-12)
    single = after(scene, 30, propagators.create("dom8"), bands=2, precision="float32")
    np.testing.assert_allclose(single.ledger.medium, double.ledger.medium, rtol=1e-4)


@pytest.mark.parametrize("name", ["dom6", "dom26"])
def test_three_dimensions_keep_books_too(name):
    scene = Scene.from_dict(
        {
            "grid": {"shape": [5, 4, 6]},
            "light": [{"kind": "cell", "cell": [2, 2, 2], "flux": 1.0}],
            "medium": {"extinction": 0.9, "albedo": 0.8},
        }
    )
    ledger = after(scene, 12, propagators.create(name), bands=2).ledger
    assert abs(ledger.closure) < ROUNDING
    assert ledger.medium > 0.1


# -- the scene ----------------------------------------------------------------------------------


def test_the_medium_is_part_of_the_scene():
    scene = medium_scene(0.5, 0.25)
    assert scene.medium == Medium(0.5, 0.25)
    assert parse_scene(scene_to_toml(scene)) == scene
    assert "[medium]\nextinction = 0.5\nalbedo = 0.25\n" in scene_to_toml(scene)
    black = parse_scene("[grid]\nshape = [4, 4]\n[medium]\nalbedo = 0.5\n")
    assert black.medium is None
    assert parse_scene(scene_to_toml(black)) == black


@pytest.mark.parametrize(
    ("table", "rule"),
    [
        ({"extinction": -1.0}, "medium, extinction = -1.0: must be at least 0"),
        ({"extinction": "thick"}, "medium, extinction = 'thick': must be a number"),
        ({"extinction": 1.0, "albedo": 1.5}, "medium, albedo = 1.5: must be at most 1"),
        ({"extinctoin": 1.0}, "is an unknown key; did you mean 'extinction'"),
    ],
)
def test_bad_media_are_refused(table, rule):
    with pytest.raises(SceneError, match=rule):
        Scene.from_dict({"grid": {"shape": [4, 4]}, "medium": table})


def flat_schemes(media):
    classes = [propagators.find(name) for name in propagators.names()]
    return [each.name for each in classes if each.media is media and 2 in each.dimensions]


@pytest.mark.parametrize("name", flat_schemes(media=False))
def test_schemes_of_a_vacuum_refuse_a_medium(name):
    """And name those that know one, and what they accept themselves."""
    able = ", ".join(flat_schemes(media=True))
    rule = f"medium, extinction = 0.5: fills the grid, and {name} knows a vacuum only; .*: {able}"
    with pytest.raises(InputError, match=rf"{rule}; accepted: 0$"):
        propagators.create(name).solve(medium_scene(0.5, 0.5), 2)


def test_the_reference_in_3d_refuses_a_medium():
    tables = {"grid": {"shape": [4, 4, 4]}, "medium": {"extinction": 1.0}}
    with pytest.raises(InputError, match=r"analytic knows a vacuum only; .*: lpv, .*, dom26"):
        propagators.create("analytic").solve(Scene.from_dict(tables), 2)
