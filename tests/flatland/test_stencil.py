"""A scheme as data: what it sends, how waves go through it, and what is refused."""

import numpy as np
import pytest
from stepping import neighbours, plain_step, random_stencil

from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics, basis_for
from flatland.stencil import Stencil

#: Rounding of sums of about 100 products of numbers near 1.
ROUNDING = 1e-13
BASIS = CircularHarmonics(2)
AXIAL = neighbours(2, diagonal=False)


@pytest.mark.parametrize("dimension", [2, 3])
def test_flux_gain_is_what_a_cell_sends(dimension, rng):
    stencil = random_stencil(rng, basis_for(dimension, 2), neighbours(dimension))
    values = rng.normal(size=(stencil.basis.size, *[4] * dimension))
    content = values.reshape(len(values), -1).sum(axis=1)
    sent = plain_step(stencil, values).sent
    assert stencil.flux_gain @ content == pytest.approx(sent, rel=ROUNDING)


@pytest.mark.parametrize("dimension", [2, 3])
def test_symbol_is_what_a_step_does_to_a_plane_wave(dimension, rng):
    """S(x) = a exp(i k·x) becomes A(k) a exp(i k·x), seen in the middle of a grid."""
    stencil = random_stencil(rng, basis_for(dimension, 2), neighbours(dimension))
    wave_vector = rng.uniform(-np.pi, np.pi, dimension)
    places = np.stack(np.meshgrid(*[range(3)] * dimension, indexing="ij"), axis=-1)
    amplitude = rng.normal(size=stencil.basis.size)
    wave = np.multiply.outer(amplitude, np.exp(1j * places @ wave_vector))
    arrived = plain_step(stencil, wave.real).arrived + 1j * plain_step(stencil, wave.imag).arrived
    middle = (slice(None), *[1] * dimension)
    phase = np.exp(1j * wave_vector.sum())
    expected = stencil.symbol(wave_vector) @ amplitude * phase
    np.testing.assert_allclose(arrived[middle], expected, atol=ROUNDING)


def test_symbol_takes_many_wave_vectors(rng):
    stencil = random_stencil(rng, BASIS, AXIAL)
    waves = rng.uniform(-3, 3, (4, 5, 2))
    found = stencil.symbol(waves)
    assert found.shape == (4, 5, 3, 3)
    np.testing.assert_allclose(found[2, 3], stencil.symbol(waves[2, 3]), atol=ROUNDING)


@pytest.mark.parametrize("clamp", [False, True])
def test_scaled_stencil_sends_that_much_more(clamp, rng):
    stencil = random_stencil(rng, BASIS, AXIAL, faces=3, clamp=clamp)
    values = rng.normal(size=(3, 4, 4))
    once, twice = plain_step(stencil, values), plain_step(stencil.scaled(2.5), values)
    np.testing.assert_allclose(twice.arrived, 2.5 * once.arrived, atol=ROUNDING)
    assert stencil.scaled(2.5).clamp is clamp


def test_faces_make_the_transfer(rng):
    stencil = random_stencil(rng, BASIS, AXIAL, faces=2)
    np.testing.assert_array_equal(stencil.transfer, stencil.emission @ stencil.reception)


@pytest.mark.parametrize(
    ("offsets", "rule"),
    [
        ([(2, 0)], "steps of -1, 0 or 1"),
        ([(0, 0)], "zero offset"),
        ([(1, 0, 0)], r"\(K, 2\)"),
    ],
)
def test_bad_offsets_are_refused(offsets, rule):
    with pytest.raises(InputError, match=rf"^offsets = .*{rule}"):
        Stencil(BASIS, np.array(offsets), np.zeros((1, 3, 3)))


@pytest.mark.parametrize("shape", [(3, 3, 3), (4, 5, 5), (4, 3)])
def test_transfer_of_another_shape_is_refused(shape):
    with pytest.raises(InputError, match=r"transfer = .*must be \(4, 3, 3\)"):
        Stencil(BASIS, AXIAL, np.zeros(shape))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_transfer_that_is_not_finite_is_refused(value):
    with pytest.raises(InputError, match=r"(?s)transfer = .*must be finite"):
        Stencil(BASIS, AXIAL, np.full((4, 3, 3), value))


def test_clamp_without_faces_is_refused():
    with pytest.raises(InputError, match="clamp = True: needs reception and emission"):
        Stencil(BASIS, AXIAL, np.zeros((4, 3, 3)), clamp=True)
