"""Pictures of fields, and the light on the surfaces of their scenes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import propagators
from flatland import Field, Grid, InputError, Scene, load_scene
from flatland.harmonics import basis_for
from studies.commands.run import command
from studies.figures.picture import draw_picture, tone_mapped
from studies.figures.slices import Slice, read_slice
from studies.style import figure_style, save_figure
from studies.surface import surface_errors, surface_irradiance_error, surface_samples

BOX = Scene.from_dict(
    {
        "grid": {"shape": [3, 4, 5]},
        "light": [{"kind": "cell", "cell": [1, 1, 2], "flux": 1.0}],
    }
)


def field_of(scene, colours=0):
    shape = (colours,) * bool(colours) + (1, *scene.grid.shape)
    values = np.random.default_rng(5).uniform(-0.1, 1.0, shape)
    return Field(scene.grid, basis_for(scene.grid.dimension, 1), values)


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
@pytest.mark.parametrize(("name", "colours"), [("shelf", 0), ("cornell-2d", 3)])
def test_the_same_field_gives_the_same_bytes(tmp_path, ending, name, colours):
    scene = load_scene(name)
    files = []
    for copy in ("a", "b"):
        with figure_style():
            figure = draw_picture(field_of(scene, colours), scene)
            files.append(save_figure(figure, tmp_path / f"{copy}{ending}"))
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.parametrize(("colours", "bars"), [(0, 1), (2, 1), (3, 0)])
def test_false_colours_have_a_bar_with_units_and_three_colours_none(colours, bars):
    scene = load_scene("shelf")
    with figure_style():
        figure = draw_picture(field_of(scene, colours), scene)
    assert len(figure.axes) == 1 + bars
    if bars:
        assert "[W]" in figure.axes[1].get_ylabel()
    assert figure.axes[0].get_xlabel() == "x [m]"
    _, lamps, walls = (lines.get_segments() for lines in figure.axes[0].collections)
    np.testing.assert_array_equal(lamps, [[[30, 18], [30, 28]]])
    np.testing.assert_array_equal(walls, [[[12, 16], [32, 16]]])


@pytest.mark.parametrize(("text", "shape"), [("x=0", (5, 4)), ("y=3", (5, 3)), (None, (4, 3))])
def test_a_slice_shows_one_layer_with_its_first_axis_across(text, shape):
    with figure_style():
        figure = draw_picture(field_of(BOX), BOX, read_slice(text, BOX.grid))
    assert figure.axes[0].images[0].get_array().shape == shape


def test_a_slice_shows_where_it_cuts_lights_and_walls():
    scene = load_scene("shelf-3d")
    with figure_style():
        figure = draw_picture(field_of(scene), scene, read_slice("z=4", scene.grid))
    _, lamps, walls = (lines.get_segments() for lines in figure.axes[0].collections)
    assert sorted(map(tuple, lamps[0])) == [(15, 9), (15, 14)]
    assert sorted(map(tuple, walls[0])) == [(6, 8), (16, 8)]
    assert figure.axes[0].get_title() == "Light above a shelf in 3D at z = 4.5 m"


def test_pictures_need_no_file_of_the_scene(tmp_path):
    """Data files and meshes are found from the scene's folder, which pictures do not know."""
    np.save(tmp_path / "light.npy", np.ones((1, 3, 3)))
    light = {"kind": "file", "file": "light.npy"}
    scene = Scene.from_dict({"grid": {"shape": [3, 3]}, "light": [light]}, directory=tmp_path)
    with figure_style():
        assert draw_picture(field_of(scene), scene).axes


def test_the_middle_along_z_is_shown_if_nothing_is_said():
    assert read_slice(None, BOX.grid) == Slice(2, 2)
    assert read_slice(" y = 1 ", BOX.grid) == Slice(1, 1)
    assert read_slice(None, Grid((2, 2))) is None


@pytest.mark.parametrize("text", ["w=1", "x", "x=", "x=1.5", "x=-1", "x=3", "=1", "x=²"])
def test_bad_slices_are_refused(text):
    with pytest.raises(InputError, match="--slice"):
        read_slice(text, BOX.grid)


def test_a_black_field_can_be_drawn():
    scene = load_scene("shelf")
    for colours in (0, 3):
        field = field_of(scene, colours)
        with figure_style():
            draw_picture(Field(field.grid, field.basis, 0 * field.values), scene)


@pytest.mark.parametrize(
    ("darkest", "bottom", "extend"),
    [(0.5, 0.1, "neither"), (0.02, 0.01, "neither"), (3e-7, 1e-4, "min"), (-1.0, 1e-4, "min")],
)
def test_the_bar_spans_the_decades_that_the_field_needs_and_no_more(darkest, bottom, extend):
    field = field_of(load_scene("shelf"))
    field.values[...] = 1.0
    field.values[0, 3, 3] = darkest
    with figure_style():
        axes, bar = draw_picture(field, load_scene("shelf")).axes[:2]
    scale = axes.images[0].norm
    assert scale.vmin / scale.vmax == pytest.approx(bottom)
    assert bar._colorbar.extend == extend


def test_tone_mapping_keeps_order_hue_and_range_whatever_the_unit():
    flux = np.array([[[0.0, 1.0, 2.0, 1e6]], [[0.0, 1.0, 1.0, 1e6]], [[0.0, 1.0, 0.5, -1.0]]])
    shown = tone_mapped(flux)
    assert shown.shape == (1, 4, 3)
    assert shown.min() == 0
    assert shown.max() <= 1
    assert shown[0, 2, 0] > shown[0, 2, 1] > shown[0, 2, 2]
    assert len(set(shown[0, 1])) == 1
    np.testing.assert_allclose(tone_mapped(1e3 * flux), shown, rtol=1e-12)


def _run(*arguments):
    return CliRunner().invoke(command, [str(each) for each in arguments])


def test_run_writes_a_picture_and_says_so(tmp_path):
    result = _run("two-walls", "--iterations", 2, "--image", tmp_path / "a.png")
    assert result.exit_code == 0, result.output
    assert "a.png" in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--image", "a.gif"], ["--image", "a.gif", ".png"]),
        (["--image", "a.png", "--slice", "z=1"], ["--slice", "3D"]),
        (["--slice", "z=1"], ["--slice", "--image"]),
    ],
)
def test_a_picture_that_cannot_be_is_refused_before_the_run(arguments, words):
    error = _run("shelf", *arguments).exception
    assert isinstance(error, InputError)
    for word in words:
        assert word in str(error)


def test_samples_are_short_and_carry_the_exact_flux_to_both_sides():
    scene = load_scene("shelf")
    samples = surface_samples(scene)
    exact = propagators.create("analytic")
    assert samples.sizes.max() <= scene.grid.spacing / 2 + 1e-12
    assert samples.sizes.sum() == pytest.approx(40)
    flux = samples.sizes @ samples.exact
    assert flux == pytest.approx(exact.absorbed(scene).sum(), rel=1e-9)


def test_sides_that_face_out_of_the_grid_are_left_out():
    scene = load_scene("cornell-2d")
    samples = surface_samples(scene)
    on_left = samples.points[:, 0] < 1e-9
    assert np.all(samples.normals[on_left] @ [1, 0] > 0.99)


def test_a_black_field_is_wrong_by_one_and_the_exact_field_by_its_bands():
    scene = load_scene("shelf")
    samples = surface_samples(scene)
    field = propagators.create("analytic").solve(scene, 8)
    black = Field(field.grid, field.basis, 0 * field.values)
    assert surface_irradiance_error(black, samples).error == 1.0
    # In front of the shelf, by the cosine: what 8 bands and cells leave.
    good = surface_irradiance_error(field, samples, "cosine", offset=0.5)
    assert good.error < 0.1
    assert good.ratio == pytest.approx(1, abs=0.05)
    assert good.error == min(row.error for row in surface_errors(field, samples))


def test_run_prints_the_light_on_surfaces():
    arguments = ("shelf", "--iterations", 4, "--surfaces")
    text = _run(*arguments).stdout
    for word in ("distance", "cosine", "damped", "relative L2"):
        assert word in text
    rows = json.loads(_run(*arguments, "--json").stdout)["surfaces"]
    assert len(rows) == 8
    assert all(row["error"] > 0 for row in rows)


def test_scenes_without_occluders_have_no_surfaces():
    with pytest.raises(InputError, match="no occluders"):
        surface_samples(load_scene("fig5-one-light"))
