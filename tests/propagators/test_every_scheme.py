"""What holds for every 2D scheme of the registry: books that close, and light that adds up."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from analytic_scenes import LIGHTS, make_scene

import propagators
from flatland.errors import SchemeWarning
from flatland.scene import Scene, builtin_names
from flatland.simulation import Simulation

ROUNDING = 1e-12
FLAT = [
    name
    for name in propagators.names()
    if 2 in propagators.find(name).dimensions and name != "analytic"
]
#: Cones of light that are never added up as flux.
WITHOUT_BOOKS = ("holographic-rc",)
every_bookkeeper = pytest.mark.parametrize("name", [n for n in FLAT if n not in WITHOUT_BOOKS])
every_scheme = pytest.mark.parametrize("name", FLAT)


def answered(name, scene, bands=2):
    """Field and ledger; stencils are stepped, as their books are of steps."""
    propagator = propagators.create(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SchemeWarning)
        if not isinstance(propagator, propagators.StencilPropagator):
            answer = propagator.answer(scene, bands)
            return answer.field, answer.ledger
        simulation = Simulation(scene, propagator, bands=bands)
        simulation.run(40)
        return simulation.accumulated, simulation.ledger


def scenes(name):
    plain = make_scene(albedo=0.6).to_dict()
    yield Scene.from_dict(plain)
    if propagators.find(name).media:
        for extinction, albedo in ((0.0, 0.5), (0.05, 0.9), (0.8, 0.4), (1.0, 1.0)):
            medium = {"extinction": extinction, "albedo": albedo}
            yield Scene.from_dict({**plain, "medium": medium})


@every_bookkeeper
def test_books_close(name):
    """To 1e-12 of what is emitted, in a vacuum and in any medium that the scheme knows."""
    for scene in scenes(name):
        ledger = answered(name, scene)[1]
        assert abs(ledger.closure) < ROUNDING * ledger.emitted, scene.medium
        absorbing = scene.medium is not None and scene.medium.albedo < 1
        assert (ledger.medium > 1e-3) == absorbing
        assert ledger.absorbed > 1e-3


@every_bookkeeper
def test_what_is_emitted_goes_somewhere(name):
    """Nothing is made but by schemes that say so, and they say how much."""
    ledger = answered(name, make_scene(albedo=0.6))[1]
    flux = sum(light[2] for light in LIGHTS)
    assert ledger.emitted == pytest.approx(flux, rel=1e-3)
    spent = ledger.left + ledger.absorbed + ledger.inside
    assert spent - ledger.emitted == pytest.approx(ledger.created, abs=ROUNDING * flux)


@every_scheme
def test_twice_the_light_is_twice_the_answer(name):
    bright = [(a, b, 2 * flux) for a, b, flux in LIGHTS]
    once = answered(name, make_scene(albedo=0.6))[0].values
    twice = answered(name, make_scene(lights=bright, albedo=0.6))[0].values
    # Solvers stop at a relative residual of 1e-10.
    np.testing.assert_allclose(twice, 2 * once, rtol=0, atol=1e-8 * np.abs(once).max())


@pytest.mark.parametrize("name", propagators.names())
def test_every_scheme_says_what_it_gets_wrong(name):
    """Those that do not step with a scene that shows it, in the manual too."""
    scheme = propagators.find(name)
    text = scheme.__doc__ or ""
    assert "gets wrong" in text
    if issubclass(scheme, propagators.DirectPropagator):
        assert any(f"`{scene}`" in text for scene in builtin_names())
        manual = (Path(__file__).parents[2] / "docs" / "accurate.md").read_text("utf-8")
        assert name in "".join(line for line in manual.splitlines() if line.startswith("## "))
