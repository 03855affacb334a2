"""Every figure: from its stored data alone, the same bytes each time, and fit to be printed."""

from __future__ import annotations

import importlib
import json

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from small_studies import run_here, small, small_dataset, study_of

from flatland.errors import FlatlandError
from flatland.results import load_dataset, save_dataset
from flatland.scene import parse_scene
from studies.command_line import _run
from studies.figures import FIGURES
from studies.figures.pareto import best_per_decade, front
from studies.figures.workshop import StudyFolder
from studies.style import figure_style, save_figure

every_figure = pytest.mark.parametrize("name", FIGURES)


class SmallWorkshop:
    """Gives small versions of studies."""

    def study(self, name):
        return load_dataset(small_dataset(name))


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Data of a figure, computed once, stored and read again."""
    folder = tmp_path_factory.mktemp("figures")
    workshop, known = SmallWorkshop(), {}
    module_of("clpv-fig5").BANDS = (2,)  # 8 bands take seconds to compile
    module_of("octree-table1").SCENE = "clutter:size=16,occluders=3"
    module_of("octree-table1").REPEATS = 1

    def of(name):
        if name not in known:
            computed = module_of(name).compute(workshop)
            known[name] = {
                part: save_dataset(computed[part], folder / f"{name}-{part}.nc")
                for part in module_of(name).PARTS
            }
        return {part: load_dataset(path) for part, path in known[name].items()}

    return of


def module_of(name):
    return importlib.import_module(FIGURES[name][0])


def test_the_figures_of_the_papers_and_ours_are_there():
    ours = "bands iterations resolution stability dispersion pareto drift blocking"
    accurate = "ray-effects false-scattering penumbra medium-moments"
    clpv = "clpv-fig2 clpv-fig5 clpv-fig11 clpv-fig12"
    octree = "octree-fig2 octree-fig3 octree-fig7 octree-fig9 octree-fig14 octree-fig15"
    more = "octree-fig16 octree-fig17 octree-table1 levels pareto-all"
    named = f"{ours} {clpv} {octree} {more} {accurate}"
    assert set(named.split()) <= set(FIGURES)


def test_converged_points_on_the_front_wear_a_ring(stored):
    data = dict(stored("pareto"))
    rows = next(iter(data))
    stops = np.full(data[rows].sizes["row"], "converged")
    data[rows] = data[rows].assign(stop=("row", stops))
    with figure_style():
        (figure,) = module_of("pareto").draw(data).values()
    rings = [line for line in figure.axes[0].lines if line.get_markersize() == 7]
    assert rings


@every_figure
def test_a_figure_is_drawn_from_its_data_alone_a_column_wide(name, stored):
    with figure_style():
        figures = module_of(name).draw(stored(name))
    assert figures
    for figure in figures.values():
        assert figure.get_size_inches()[0] * 25.4 == pytest.approx(85)
        assert figure.axes


#: Drawing takes time: all figures are looked at closely by the slow tests, one always.
_SOON = ("drift",)
_LATER = [pytest.param(name, marks=pytest.mark.slow) for name in FIGURES if name not in _SOON]
some_soon = pytest.mark.parametrize("name", [*_SOON, *_LATER])


@some_soon
def test_all_that_a_figure_shows_is_inside(name, stored):
    with figure_style():
        for part, figure in module_of(name).draw(stored(name)).items():
            width, height = figure.get_size_inches()
            FigureCanvasAgg(figure)
            figure.draw_without_rendering()
            box = figure.get_tightbbox()
            slack = 0.02  # inch
            assert min(box.x0, box.y0) > -slack, part
            assert (box.x1 < width + slack, box.y1 < height + slack) == (True, True), part


@some_soon
def test_the_same_data_gives_the_same_bytes_with_fonts_inside(name, stored, tmp_path):
    data = stored(name)
    first, second = (drawn(name, data, tmp_path / each) for each in ("a", "b"))
    assert first == second
    for content in first.values():
        assert b"/FontFile2" in content
        assert b"/CreationDate" not in content


def drawn(name, data, folder):
    """Bytes of every part as PDF."""
    with figure_style():
        figures = module_of(name).draw(data)
        paths = {part: save_figure(each, folder / f"x{part}.pdf") for part, each in figures.items()}
    return {part: path.read_bytes() for part, path in paths.items()}


@every_figure
def test_every_number_says_how_to_get_it(name, stored):
    """Rows have commands and scenes; pictures of fields have scene and methods."""
    for part, data in stored(name).items():
        if "command" in data:
            assert all(text.split()[0] in ("flatland", "python") for text in data["command"].values)
        elif name == "resolution":
            assert part == "orders"  # fitted to the rows beside it
        elif "methods" in data.attrs:
            assert json.loads(data.attrs["methods"])
            assert parse_scene(data.attrs["scene"]).lights
        else:
            assert data.attrs["command"].startswith("python")
        if "scene_digest" in data:
            scenes = json.loads(data.attrs["scenes"])
            assert all(parse_scene(scenes[digest]) for digest in data["scene_digest"].values)


#: Figures of rows, and the columns that their curves show.
CURVES = {
    "bands": ("angular", "coefficients"),
    "iterations": ("coefficients",),
    "levels": ("coefficients",),
    "octree-fig15": (
        "printed_absolute",
        "printed_relative",
        "corrected_relative",
        "coefficients",
    ),
    "resolution": ("coefficients",),
    "drift": ("drift",),
    "pareto": ("angular",),
    "pareto-all": ("angular", "coefficients", "floor"),
}


@pytest.mark.parametrize("name", CURVES)
def test_every_point_of_a_curve_is_a_number_of_a_row(name, stored):
    data = stored(name)
    known = {0.0}
    for column in CURVES[name]:
        known |= set(data["rows"][column].values.tolist())
    with figure_style():
        figures = module_of(name).draw(data)
    axes = [each for figure in figures.values() for each in figure.axes]
    shown = {float(y) for each in axes for line in each.lines for y in line.get_ydata()}
    assert shown
    if name == "pareto-all":  # what is next to nothing stands at the lower edge of its panel
        known.add(module_of(name).LEAST)
    assert shown <= known


def test_every_scheme_has_an_order_and_its_interval(tmp_path):
    study = study_of(
        {
            "scenes": ["tiny", "two-walls"],
            "propagators": ["lpv", "dom8", "beam:ordinates=16"],
            "resolution": [1, 2, 3],
            "converge": 1e-3,
        }
    )
    rows = load_dataset(run_here(study, tmp_path).dataset)
    orders = module_of("resolution").orders_of(rows)
    coefficients = orders.isel(row=orders["measure"].values == "coefficients")
    assert set(coefficients["scheme"].values) == set(rows["scheme"].values)
    assert (coefficients["low"] < coefficients["order"]).all()
    assert (coefficients["order"] < coefficients["high"]).all()


def test_the_command_writes_pictures_and_data_and_draws_them_again(tmp_path, capsys):
    folder = tmp_path / "out"
    assert _run(["figure", "clpv-fig2", "-o", str(folder)]) == 0
    names = {path.name for path in folder.iterdir()}
    assert names == {f"clpv-fig2{rest}" for rest in (".pdf", ".png", "-faces.nc", "-faces.csv")}
    before = {path: path.read_bytes() for path in folder.iterdir()}
    for path in folder.glob("*.p*"):
        path.unlink()
    assert _run(["figure", "clpv-fig2", "--data", "-o", str(folder)]) == 0
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_figure_of_a_study_goes_on_with_the_cases_that_are_there(tmp_path, monkeypatch):
    from studies.sweeps import study as study_module

    tiny = small("growth")
    monkeypatch.setattr(study_module, "load_study", lambda name: tiny)
    before = run_here(tiny, tmp_path / "studies" / "growth")
    assert before.done > 0
    path = next((tmp_path / "studies" / "growth" / "cases").iterdir())
    stamp = path.stat().st_mtime_ns
    data = StudyFolder(tmp_path, jobs=1).study("growth")
    assert data.sizes["row"] > 0
    assert path.stat().st_mtime_ns == stamp


def test_a_study_without_a_single_good_case_makes_no_figure(tmp_path, monkeypatch):
    from studies.sweeps import study as study_module

    unstable = {"scenes": "tiny", "propagators": "dom4:emission=delta", "bands": 3}
    bad = study_of({**unstable, "converge": 1e-3})
    monkeypatch.setattr(study_module, "load_study", lambda name: bad)
    with pytest.raises(FlatlandError, match=r"no case succeeded; first: .*1\.2732"):
        StudyFolder(tmp_path, jobs=1).study("bad")


def test_the_best_of_a_decade_is_the_fastest_of_equals():
    columns = {
        "scene": ["a", "a", "a", "a", "b"],
        "seconds": [0.2, 0.9, 0.3, 2.0, 5.0],
        "angular": [0.5, 0.4, 0.4 + 1e-12, 0.1, 0.7],
    }
    rows = xr.Dataset({name: ("row", values) for name, values in columns.items()})
    best = best_per_decade(rows)
    assert best["seconds"].values.tolist() == [0.3, 2.0, 5.0]
    assert best["decade"].values.tolist() == [-1, 0, 0]


def test_the_front_holds_what_nothing_beats():
    seconds = [1.0, 2.0, 3.0, 1.0, 2.5, 0.5, 3.0]
    errors = [0.5, 0.4, 0.4, 0.6, 0.3, 0.9, 0.3]
    on = [True, True, False, False, True, True, False]
    assert front(seconds, errors).tolist() == on
    for point in zip(seconds, errors):
        ahead = [
            other
            for other, good in zip(zip(seconds, errors), on)
            if good and other[0] <= point[0] and other[1] <= point[1]
        ]
        assert ahead
