"""Any small scene, through every scheme."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import after
from schemes import combinations, stencil_classes

import propagators
from flatland.scene import Scene
from propagators import StencilPropagator

#: Rounding of some dozen steps in float64, relative to the largest coefficient.
ROUNDING = 1e-12
#: What differs where light between walls is iterated to residuals of 1e-10: the last round may
#: fall on either side of the goal. Schemes that go on to 1e-13 and less are held to rounding.
SETTLED, TO_ROUNDING = 1e-9, ("analytic", "beam", "lattice-boltzmann")

SIDES = {2: st.integers(1, 12), 3: st.integers(1, 5)}
#: Bands that are tried; in space more of them take long to compile.
BANDS = {2: st.integers(1, 4), 3: st.integers(1, 2)}
fluxes = st.integers(1, 1000).map(lambda n: n / 100)
angles = st.integers(0, 359).map(np.radians)


@st.composite
def scenes(draw, dimension):
    """A small grid with some cell lights and, where one fits in, an area light."""
    shape = draw(st.tuples(*[SIDES[dimension]] * dimension))
    lights = []
    for _ in range(draw(st.integers(1, 3))):
        cell = [draw(st.integers(0, n - 1)) for n in shape]
        light = {"kind": "cell", "cell": cell, "flux": draw(fluxes)}
        if draw(st.booleans()):
            angle = draw(angles)
            height = [draw(st.sampled_from([-2.0, 0.0, 0.5]))] * (dimension - 2)
            light["direction"] = [float(np.cos(angle)), float(np.sin(angle)), *height]
        lights.append(light)
    if min(shape) >= 3 and draw(st.booleans()):
        # A cell away from the border, so that the half cell in front is in the grid.
        inside = [st.integers(100, 100 * (n - 1)).map(lambda c: c / 100) for n in shape]
        corners = [draw(st.tuples(*inside)) for _ in range(dimension)]
        sides = np.subtract(corners[1:], corners[0])
        if np.linalg.det(sides @ sides.T) > 1e-3:
            shape_keys = {"start": corners[0], "end": corners[1]}
            keys = shape_keys if dimension == 2 else {"vertices": corners}
            lights.append({"kind": "area", **keys, "flux": draw(fluxes)})
    return {"grid": {"shape": shape}, "light": lights}


def dimmed(data, factor):
    lights = [dict(light, flux=factor * light["flux"]) for light in data["light"]]
    return {**data, "light": lights}


@pytest.mark.parametrize(
    ("scheme", "dimension"),
    [(scheme, dimension) for scheme in stencil_classes() for dimension in scheme.dimensions],
    ids=lambda value: getattr(value, "name", value),
)
@given(draw=st.data())
def test_any_scene_is_finite_balanced_and_linear_in_flux(scheme, dimension, draw):
    data, bands = draw.draw(scenes(dimension)), draw.draw(BANDS[dimension])
    propagator = draw.draw(st.sampled_from(list(combinations(scheme))))
    simulation = after(Scene.from_dict(data), 12, propagator, bands=bands)
    field, ledger = simulation.accumulated, simulation.ledger
    assert np.all(np.isfinite(field.values))
    size = sum(abs(float(entry)) for entry in ledger.as_dict().values())
    assert abs(ledger.closure) < ROUNDING * size
    half = after(Scene.from_dict(dimmed(data, 0.5)), 12, propagator, bands=bands)
    # Half of everything, bit for bit: powers of two change no digit.
    np.testing.assert_array_equal(2 * half.accumulated.values, field.values)
    third = after(Scene.from_dict(dimmed(data, 1 / 3)), 12, propagator, bands=bands)
    tolerance = ROUNDING * np.abs(field.values).max()
    np.testing.assert_allclose(3 * third.accumulated.values, field.values, rtol=0, atol=tolerance)


@st.composite
def walls(draw, shape):
    """Some segments, black or grey, anywhere in the grid and somewhat beyond."""
    corners = [st.integers(-4, 4 * n + 4).map(lambda c: c / 4) for n in shape]
    ends = [draw(st.tuples(*corners)) for _ in range(2 * draw(st.integers(0, 4)))]
    albedo = draw(st.sampled_from([0.0, 0.5]))
    return [
        {"kind": "segment", "start": start, "end": end, "albedo": albedo}
        for start, end in zip(ends[::2], ends[1::2])
        if start != end
    ]


def direct_schemes():
    """Schemes that answer a scene without stepping it."""
    found = map(propagators.find, propagators.names())
    return [scheme for scheme in found if not issubclass(scheme, StencilPropagator)]


@pytest.mark.parametrize("scheme", direct_schemes(), ids=lambda scheme: scheme.name)
@given(draw=st.data())
def test_any_scene_with_walls_has_a_finite_linear_direct_answer(scheme, draw):
    data, bands = draw.draw(scenes(2)), draw.draw(BANDS[2])
    data["occluder"] = draw.draw(walls(data["grid"]["shape"]))
    propagator = scheme()
    values = propagator.solve(Scene.from_dict(data), bands).values
    assert np.all(np.isfinite(values))
    third = propagator.solve(Scene.from_dict(dimmed(data, 1 / 3)), bands).values
    share = ROUNDING if scheme.name in TO_ROUNDING else SETTLED
    tolerance = share * np.abs(values).max()
    np.testing.assert_allclose(3 * third, values, rtol=0, atol=tolerance)


@given(draw=st.data())
def test_the_books_of_the_reference_close_in_any_scene(draw):
    data = draw.draw(scenes(2))
    data["occluder"] = draw.draw(walls(data["grid"]["shape"]))
    ledger = propagators.create("analytic").energy(Scene.from_dict(data))
    assert abs(ledger.closure) < 1e-10 * ledger.emitted  # what numerics §6 asks for
