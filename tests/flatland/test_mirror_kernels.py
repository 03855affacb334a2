"""Steps of half a field that is its own mirror image are those of the whole."""

import itertools

import numpy as np
import pytest
from images import symmetric_light, symmetric_shares, symmetric_stencil
from stepping import neighbours, random_stencil

import propagators
from flatland.folding import Fold, wall_axes
from flatland.harmonics import basis_for
from flatland.kernels import Layout, Reflection, Sweep, sweep
from flatland.occlusion import Occlusion
from flatland.symmetry import image_offsets, scheme_axes

#: Even and odd numbers of cells; rows shorter and longer than vectors, before and after halving.
SHAPES = [(12, 20), (13, 20), (9, 35), (6, 8, 10), (7, 5, 11), (4, 7, 34)]


def some_of(axes):
    """All sets of axes but the empty one."""
    counts = range(1, axes + 1)
    return [chosen for n in counts for chosen in itertools.combinations(range(axes), n)]


CASES = [
    pytest.param(shape, axes, id=f"{shape}-{axes}")
    for shape in SHAPES
    for axes in some_of(len(shape))
]


def run(stencil, layout, light, occlusion=None, count=5, lit=None, sums=(0, 1)):
    """Newest light, the sum of all, and reports."""
    occlusion = occlusion or Occlusion()
    stepper = Sweep(stencil, layout, occlusion.transmittance, sums)
    stepper = stepper.reflecting(*(occlusion.reflections or (None,)))
    source, target, total = (layout.allocate() for _ in range(3))
    layout.view(source)[...] = light
    reports = stepper.steps(source, target, total, count, lit)
    newest = target if count % 2 else source
    return layout.view(newest).copy(), layout.view(total).copy(), reports


def assert_halves_agree(
    stencil, shape, axes, light, occlusion=None, dtype=np.float64, count=5, sums=(0, 1)
):
    fold = Fold(shape, stencil.basis, axes)
    whole = Layout(shape, stencil.basis.size, np.dtype(dtype))
    light = light.astype(dtype)
    expected = run(stencil, whole, light, occlusion, count, sums=sums)
    halved = occlusion and fold.occlusion(occlusion)
    found = run(stencil, fold.layout(whole), fold.half(light), halved, count, sums=sums)
    rounding = 40 * np.finfo(dtype).eps
    for mine, all_ in zip(found[:2], expected[:2]):
        limit = rounding * np.abs(expected[1]).max()
        np.testing.assert_allclose(fold.whole(mine), all_, rtol=0, atol=limit)
    # Each sum to the rounding of what is summed.
    cells = np.prod(shape) * np.abs(expected[1]).max()
    for name in ("components", "squares", "left", "sent", "reflected"):
        mine, all_ = (getattr(reports, name) for reports in (found[2], expected[2]))
        assert (mine is None) == (all_ is None)
        if mine is not None:
            size = cells * (np.abs(light).max() if name == "squares" else 1)
            np.testing.assert_allclose(mine, all_, rtol=0, atol=rounding * size)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("shape", "axes"), CASES)
@pytest.mark.parametrize("diagonal", [False, True])
def test_half_of_a_random_field_steps_like_the_whole(shape, axes, diagonal, dtype, rng):
    basis = basis_for(len(shape), 2)
    stencil = random_stencil(rng, basis, neighbours(len(shape), diagonal))
    stencil = symmetric_stencil(stencil, axes)
    light = symmetric_light(rng, basis, shape, axes)
    assert_halves_agree(stencil, shape, axes, light, dtype=dtype)


@pytest.mark.parametrize("everywhere", [False, True])
@pytest.mark.parametrize(("shape", "axes"), CASES)
def test_half_of_the_links(shape, axes, everywhere, rng, monkeypatch):
    """τ of images, too; in all vectors, and only in those that walls are near."""
    monkeypatch.setattr(sweep, "is_written_twice", lambda couplings: not everywhere)
    basis = basis_for(len(shape), 2)
    stencil = symmetric_stencil(random_stencil(rng, basis, neighbours(len(shape))), axes)
    occlusion = Occlusion(symmetric_shares(rng, stencil, shape, axes))
    light = symmetric_light(rng, basis, shape, axes)
    assert_halves_agree(stencil, shape, axes, light, occlusion)


def symmetric_reflection(rng, stencil, shape, axes, share=0.2):
    """Random lobes in a part of the cells, which are their own image."""
    lobes = rng.normal(size=(*shape, len(stencil.offsets), stencil.basis.size)) / 10
    lobes[rng.uniform(size=shape) > share] = 0
    for axis in axes:
        signs = stencil.basis.parities[:, axis]
        lobes = lobes + np.flip(lobes, axis)[..., image_offsets(stencil, axis), :] * signs
    cells = np.argwhere(lobes.any(axis=(-2, -1)))
    return Reflection(cells, lobes[tuple(cells.T)])


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize(("shape", "axes"), CASES)
def test_half_of_what_walls_send_back(shape, axes, clamp, rng):
    basis = basis_for(len(shape), 2)
    faces = 3 if clamp else 0
    stencil = random_stencil(rng, basis, neighbours(len(shape), False), faces, clamp)
    stencil = symmetric_stencil(stencil, axes)
    tau = symmetric_shares(rng, stencil, shape, axes)
    reflection = symmetric_reflection(rng, stencil, shape, axes)
    occlusion = Occlusion(tau, (reflection,))
    assert set(axes) <= set(wall_axes(occlusion, stencil, shape, range(len(shape))))
    light = symmetric_light(rng, basis, shape, axes)
    assert_halves_agree(stencil, shape, axes, light, occlusion)


@pytest.mark.parametrize("blocked", [False, True])
@pytest.mark.parametrize(("shape", "axes"), CASES)
def test_half_by_matrices(shape, axes, blocked, rng, monkeypatch):
    monkeypatch.setattr(sweep, "LARGEST_TEXT", 0)
    basis = basis_for(len(shape), 2)
    stencil = symmetric_stencil(random_stencil(rng, basis, neighbours(len(shape))), axes)
    tau = symmetric_shares(rng, stencil, shape, axes) if blocked else None
    light = symmetric_light(rng, basis, shape, axes)
    assert_halves_agree(stencil, shape, axes, light, Occlusion(tau))


@pytest.mark.parametrize("threads", ["2", "3"])
@pytest.mark.parametrize(("shape", "axes"), [((13, 20), (0, 1)), ((7, 8, 11), (0, 1, 2))])
def test_threads_make_images_of_their_own_rows(shape, axes, threads, rng, monkeypatch):
    monkeypatch.setenv("FLATLAND_THREADS", threads)
    monkeypatch.setattr(sweep, "_WORTH_SHARING_BATCH", 0)
    basis = basis_for(len(shape), 2)
    stencil = symmetric_stencil(random_stencil(rng, basis, neighbours(len(shape))), axes)
    for _ in range(5):
        light = symmetric_light(rng, basis, shape, axes)
        assert_halves_agree(stencil, shape, axes, light, count=40)


def test_images_that_were_left_behind_are_forgotten(rng):
    """Light that is not at the mirror has no images there, whatever was there before."""
    basis = basis_for(2, 2)
    stencil = propagators.create("dom8").stencil(basis)
    layout = Layout((12, 12), basis.size, np.dtype(float))
    half = Fold((12, 12), basis, (0, 1)).layout(layout)
    stepper = Sweep(stencil, half)
    source, target, total = (half.allocate() for _ in range(3))
    half.view(source, images=True)[...] = half.view(target, images=True)[...] = 1.0
    for buffer in (source, target):
        half.view(buffer)[...] = 0.0
    half.view(source)[:, 1, 1] = 1.0
    stepper.steps(source, target, total, 2, ((1, 2), (1, 2)))
    expected = np.zeros_like(half.view(total))
    expected[:, :4, :4] = half.view(total)[:, :4, :4]
    np.testing.assert_array_equal(half.view(total), expected)


@pytest.mark.parametrize(("shape", "axes"), CASES)
def test_whole_light_is_the_half_and_its_images(shape, axes, rng):
    basis = basis_for(len(shape), 3)
    light = symmetric_light(rng, basis, shape, axes)
    fold = Fold(shape, basis, axes)
    np.testing.assert_array_equal(fold.whole(fold.half(light)), light)
    assert fold.half(light).shape[1:] == fold.half_shape
    assert np.prod(fold.half_shape) < 0.7 * np.prod(shape)


def test_a_box_and_its_images():
    fold = Fold((9, 12), basis_for(2, 1), (0,))
    assert fold.half_box(((2, 7), (3, 12))) == ((2, 5), (3, 12))
    assert fold.whole_box(((2, 3), (3, 12))) == ((2, 7), (3, 12))
    assert fold.whole_box(((0, 0), (0, 0))) == ((0, 0), (0, 0))


@pytest.mark.parametrize("dimension", [2, 3])
def test_axes_of_random_schemes_are_found(dimension, rng):
    basis = basis_for(dimension, 3)
    for clamp in (False, True):
        stencil = random_stencil(rng, basis, neighbours(dimension), 2 * clamp, clamp)
        assert scheme_axes(stencil) == ()
        for axes in some_of(dimension):
            assert scheme_axes(symmetric_stencil(stencil, axes)) == axes


def test_a_scheme_without_a_neighbours_image_is_not_its_own(rng):
    basis = basis_for(2, 2)
    stencil = random_stencil(rng, basis, np.array([[1, 0], [0, 1], [0, -1]]))
    assert image_offsets(stencil, 0) is None
    assert scheme_axes(stencil) == ()
    stencil = symmetric_stencil(stencil, (1,))
    assert scheme_axes(stencil) == (1,)
