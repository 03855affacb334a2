"""Octrees on the command line, in result files and in pictures."""

import json

import numpy as np
import pytest
from scenes import LPV, scene_of

import propagators
from flatland import Simulation, load_scene
from flatland.errors import InputError
from flatland.results import load_dataset, result_dataset, save_dataset
from studies.command_line import _run
from studies.figures.level_borders import level_borders
from studies.figures.picture import draw_picture
from studies.figures.slices import read_slice
from studies.running import Method, run_method
from studies.style import figure_style

RULES = {"levels": 4, "normalization": "mean", "index": "symmetric", "patience": 1.5, "blend": 1.0}


@pytest.fixture
def flatland(capsys, tmp_path, monkeypatch):
    """The command line in this process: exit code, output, messages."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        code = _run([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def test_a_run_prints_every_level_and_writes_them_all(flatland, tmp_path):
    code, output, messages = flatland(
        "run", "level-jump", "--levels", 3, "--iterations", 4, "--json", "-o", "a.nc",
        "--image", "a.png", "--view", "level:1",
    )  # fmt: skip
    assert code == 0, messages
    record = json.loads(output)
    assert [level["shape"] for level in record["levels"]] == [[16, 16], [8, 8], [4, 4]]
    assert [level["factor"] for level in record["levels"]] == [1, 2, 4]
    assert sum(level["cells_read"] for level in record["levels"]) == 256
    assert record["levels"][1]["ledger"]["emitted"] == pytest.approx(0.5)
    assert record["method"]["levels"] == 3
    assert (tmp_path / "a.png").stat().st_size > 1000

    simulation = Simulation(load_scene("level-jump"), LPV, levels=3)
    simulation.run(4)
    data = load_dataset(tmp_path / "a.nc")
    np.testing.assert_array_equal(data["accumulated"], simulation.merge().values)
    np.testing.assert_array_equal(data["index"], simulation.index)
    for number, axes in enumerate((("x", "y"), ("x_1", "y_1"), ("x_2", "y_2"))):
        stored = data[f"level_{number}"]
        assert stored.dims == ("coefficient", *axes)
        np.testing.assert_array_equal(stored, simulation.level(number).accumulated.values)
        assert float(stored[axes[0]][0]) == 0.5 * 2**number


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--levels", "6"], ["levels = 6", "1 to 5", "16 x 16 cells become one cell"]),
        (["--levels", "two"], ["--levels", "two"]),
        (["--levels", "2", "--normalization", "sum"], ["normalization", "flux, mean"]),
        (["--levels", "2", "--index", "last"], ["index", "finest, symmetric"]),
        (["--levels", "2", "--patience", "0"], ["patience = 0.0", "at least 1"]),
        (["--levels", "2", "--blend", "-1"], ["blend = -1.0", "at least 0"]),
        (["--levels", "2", "--level-factors", "1,x"], ["--level-factors", "1,2.5,7"]),
        (["--levels", "2", "--level-factors", "1,2,3"], ["level_factors", "2 positive numbers"]),
        (["--view", "level:0"], ["--view = 'level:0'", "needs --image"]),
        (["--view", "level:2", "--levels", "2", "--image", "a.png"], ["merged, level:0, level:1"]),
        (["--propagator", "analytic", "--levels", "2"], ["levels = 2", "analytic does not step"]),
    ],
)
def test_what_cannot_be_is_refused(arguments, words, flatland, tmp_path):
    code, output, messages = flatland("run", "level-jump", "--iterations", 1, *arguments)
    assert code == 2
    assert output == ""
    for word in words:
        assert word in messages
    assert not list(tmp_path.iterdir())


def test_comparing_octrees_needs_iterations(flatland):
    code, _, messages = flatland("compare", "level-jump", "--levels", 3)
    assert code == 2
    assert "--levels = 3: needs --iterations" in messages


def test_octrees_are_compared_by_their_merged_fields(flatland):
    arguments = ("compare", "level-jump", "--bands", 2, "--propagator", "lpv", "--json")
    found = []
    for levels in (1, 4):
        code, output, messages = flatland(*arguments, "--iterations", 3, "--levels", levels)
        assert code == 0, messages
        found.append(json.loads(output)["runs"][0])
    assert found[1]["method"]["levels"] == 4
    assert found[1]["errors"]["coefficients"] < found[0]["errors"]["coefficients"]


def test_tables_have_a_row_per_level(flatland):
    code, output, _ = flatland("run", "level-jump", "--levels", 3, "--iterations", 2)
    assert code == 0
    rows = [line.split() for line in output.splitlines()[2:]]
    assert [row[:6] for row in rows if row[:1] in (["0"], ["1"], ["2"])] == [
        ["0", "16", "x", "16", "1", "13"],
        ["1", "8", "x", "8", "2", "39"],
        ["2", "4", "x", "4", "4", "204"],
    ]


class TestMethod:
    def test_a_merged_field_is_what_came_of_it(self):
        scene = scene_of()
        run = run_method(scene, Method(LPV, iterations=3, **RULES))
        simulation = Simulation(
            scene, LPV, levels=4, normalization="mean", index="symmetric", patience=1.5
        )
        simulation.run(3)
        np.testing.assert_array_equal(run.accumulated.values, simulation.merge(1.0).values)
        np.testing.assert_array_equal(run.index, simulation.index)
        assert run.levels == ()

    def test_levels_are_kept_if_asked_for(self):
        run = run_method(scene_of(), Method(LPV, iterations=3, **RULES), keep_levels=True)
        assert [level.accumulated.grid.shape for level in run.levels] == [
            (8, 7), (4, 4), (2, 2), (1, 1),
        ]  # fmt: skip
        assert sum(level.read for level in run.levels) == 56
        assert run.levels[0].ledger.emitted == run.ledger.emitted

    def test_a_stored_method_does_the_same_again(self, tmp_path):
        scene = scene_of()
        method = Method(LPV, iterations=3, **RULES)
        run = run_method(scene, method)
        data = result_dataset(scene, {"accumulated": run.accumulated}, method.as_dict())
        read = load_dataset(save_dataset(data, tmp_path / "a.nc"))
        stored = json.loads(read.attrs["method"])
        stored["propagator"] = propagators.create(stored["propagator"], **stored.pop("options"))
        again = run_method(scene, Method(**stored))
        np.testing.assert_array_equal(again.accumulated.values, run.accumulated.values)

    def test_a_uniform_method_says_nothing_of_levels(self):
        assert "levels" not in Method(LPV).as_dict()

    def test_a_blend_is_checked_before_the_run(self):
        with pytest.raises(InputError, match="blend"):
            Method(LPV, levels=2, blend=-1.0).simulation(scene_of())


class TestPictures:
    def test_borders_lie_between_cells_of_different_levels(self):
        index = np.array([[0, 0], [0, 1], [2, 1]])
        found = {tuple(map(tuple, side)) for side in level_borders(index).tolist()}
        assert found == {
            ((1.0, 1.0), (1.0, 2.0)),
            ((2.0, 0.0), (2.0, 1.0)),
            ((1.0, 1.0), (2.0, 1.0)),
            ((2.0, 1.0), (3.0, 1.0)),
        }
        assert len(level_borders(np.zeros((3, 4), int))) == 0

    def test_merged_pictures_have_bolder_lines_where_levels_meet(self):
        simulation = Simulation(load_scene("level-jump"), LPV, levels=5)
        simulation.run(2)
        lines = {}
        with figure_style():
            for index in (None, simulation.index):
                axes = draw_picture(simulation.merge(), simulation.scene, None, index).axes[0]
                lines[index is None] = [
                    collection.get_segments()
                    for collection in axes.collections
                    if len(collection.get_segments()) == len(level_borders(simulation.index))
                ]
        assert len(lines[False]) == 2
        assert lines[True] == []

    def test_a_slice_of_a_level_in_space(self):
        scene = scene_of([{"kind": "cell", "cell": [1, 1, 1], "flux": 1.0}], (8, 8, 8))
        simulation = Simulation(scene, LPV, levels=3)
        simulation.run(1)
        grid = simulation.level(1).grid
        with pytest.raises(InputError, match="at most 3"):
            read_slice("z=4", grid)
        with figure_style():
            layer = read_slice("z=3", grid)
            figure = draw_picture(simulation.level(1).accumulated, scene, layer)
            assert figure.axes[0].get_images()[0].get_array().shape == (4, 4)
            field, layer = simulation.merge(), read_slice("x=2", scene.grid)
            bare = draw_picture(field, scene, layer).axes[0]
            bordered = draw_picture(field, scene, layer, simulation.index).axes[0]
            assert len(bordered.collections) == len(bare.collections) + 2


class TestScenes:
    """Built-in scenes show what the thesis' figures show."""

    def test_figure_9_two_walls(self):
        scene = load_scene("two-walls")
        simulation = Simulation(scene, LPV, levels=5)
        simulation.start()
        flux = simulation.accumulated.scalar_flux()
        np.testing.assert_allclose(flux[[0, -1]], 1.0)
        assert not flux[1:-1].any()
        simulation.run(2)
        assert set(np.unique(simulation.index)) == {0, 1, 2}
        # The same along the walls, and from both sides.
        merged = simulation.merge().scalar_flux()
        np.testing.assert_allclose(merged, merged[::-1], atol=1e-14)

    def test_figure_16_back_bleeding(self):
        """Light behind the lit cell after two iterations, more after three; in truth none.

        With negative light cut off, as on the thesis' graphics card.
        """
        scene = load_scene("back-bleeding")
        x = scene.lights[0].cell[0]
        simulation = Simulation(scene, propagators.create("lpv", clamp=True))
        behind = []
        for _ in range(3):
            simulation.step()
            behind.append(float(simulation.accumulated.scalar_flux()[:x].sum()))
        assert behind[0] == 0
        assert 0.02 < behind[1] < behind[2]
        exact = propagators.create("analytic").solve(scene, 2)
        np.testing.assert_allclose(exact.scalar_flux()[:x], 0, atol=1e-14)

    def test_figure_17_level_jump(self):
        scene = load_scene("level-jump")
        run = run_method(scene, Method(LPV, iterations=0, levels=5))
        x, y = scene.lights[0].cell
        assert list(run.index[x - 7 : x + 3, y]) == [3, 3, 3, 3, 2, 2, 1, 0, 4, 4]
        smooth = run_method(scene, Method(LPV, iterations=0, levels=5, index="symmetric"))
        assert list(smooth.index[x : x + 6, y]) == [0, 1, 2, 2, 3, 3]
