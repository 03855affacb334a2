"""The command line as a user meets it: real processes, exit codes, files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from click.testing import CliRunner

from flatland.errors import InputError
from flatland.first_time import NOTICE
from flatland.results import load_dataset
from studies.commands.scene import command as scene_command

_MAIN = "from studies.command_line import main; main()"


def flatland(*arguments, cwd=None, **environment):
    """Run the command; returns the finished process with text output."""
    return subprocess.run(
        [sys.executable, "-c", _MAIN, *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, **environment},
        timeout=120,
        check=False,
    )


def _good(process):
    assert process.returncode == 0, process.stderr
    # The first command after an installation compiles kernels, and says so.
    assert all(NOTICE in line for line in process.stderr.splitlines()), process.stderr
    return process.stdout


def _refused(process, *words):
    assert process.returncode == 2, process
    assert "Traceback" not in process.stderr
    assert process.stdout == ""
    for word in words:
        assert word in process.stderr
    return process.stderr


def test_help_names_every_command():
    text = _good(flatland("--help"))
    for command in ("scene", "run", "compare", "figure"):
        assert command in text
        assert "Usage" in _good(flatland(command, "--help"))


def test_help_and_run_import_neither_plots_nor_windows():
    check = (
        "import sys; from studies.command_line import _run; "
        "code = _run({arguments!r}); "
        "found = [m for m in ('matplotlib', 'PySide6') if m in sys.modules]; "
        "print('FOUND', found); sys.exit(code or len(found))"
    )
    for arguments in (["--help"], ["run", "two-walls", "--iterations", "2"]):
        process = subprocess.run(
            [sys.executable, "-c", check.format(arguments=arguments)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert "FOUND []" in process.stdout, process.stdout + process.stderr
        assert process.returncode == 0


def test_scenes_can_be_listed_shown_checked_and_started(tmp_path):
    assert "fig5-one-light" in _good(flatland("scene", "list"))
    shown = _good(flatland("scene", "show", "fig5-one-light"))
    (tmp_path / "copy.toml").write_text(shown)
    assert "good" in _good(flatland("scene", "check", "copy.toml", cwd=tmp_path))
    _good(flatland("scene", "new", "mine.toml", cwd=tmp_path))
    assert "good" in _good(flatland("scene", "check", "mine.toml", cwd=tmp_path))


def test_a_new_scene_may_be_one_in_space(tmp_path):
    path = str(tmp_path / "mine.toml")
    assert CliRunner().invoke(scene_command, ["new", path, "--dimension", "3"]).exit_code == 0
    assert "16 x 16 x 16 cells" in CliRunner().invoke(scene_command, ["check", path]).stdout
    other = ["new", str(tmp_path / "other.toml"), "--dimension", "4"]
    with pytest.raises(InputError, match="dimension = 4: .*accepted: 2, 3"):
        CliRunner().invoke(scene_command, other, catch_exceptions=False)


MESHES = {
    "good.off": "OFF 4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n",
    # What its reader logs, with a traceback, must not be seen.
    "bad.stl": "solid a\nfacet normal x\nouter loop\n" + "vertex 1 2 3\n" * 3 + "endloop\nendsolid",
}


def test_scenes_with_meshes_are_shown_and_checked_from_anywhere(tmp_path):
    for name, text in MESHES.items():
        (tmp_path / name).write_text(text)
        scene = f'[grid]\nshape = [4, 4, 4]\n[[occluder]]\nkind = "mesh"\nfile = "{name}"\n'
        (tmp_path / f"{name}.toml").write_text(scene)
    good, bad = tmp_path / "good.off.toml", tmp_path / "bad.stl.toml"
    process = flatland("scene", "check", good, bad)
    assert process.returncode == 2
    assert "4 x 4 x 4 cells, 0 lights, 1 occluders" in process.stdout
    said = f"{bad}, line 5: occluder 1, file = 'bad.stl': has triangles without area: 1 of 1"
    assert process.stderr.startswith(said)
    assert process.stderr.count("\n") == 1
    shown = CliRunner().invoke(scene_command, ["show", str(good)]).stdout
    assert shown.endswith('kind = "mesh"\nfile = "good.off"\n')


def test_a_new_scene_never_replaces_a_file(tmp_path):
    (tmp_path / "mine.toml").write_text("precious")
    _refused(flatland("scene", "new", "mine.toml", cwd=tmp_path), "mine.toml", "exists")
    assert (tmp_path / "mine.toml").read_text() == "precious"


def test_check_reports_every_file(tmp_path):
    (tmp_path / "a.toml").write_text("[grid]\nshape = [0, 4]\n")
    (tmp_path / "b.toml").write_bytes(b"\x00\xff\x13")
    text = _refused(flatland("scene", "check", "a.toml", "b.toml", cwd=tmp_path))
    assert "a.toml" in text
    assert "b.toml" in text


def test_run_prints_books_that_balance():
    record = json.loads(_good(flatland("run", "fig5-one-light", "--bands", 3, "--json")))
    books = record["ledger"]
    assert books["emitted"] == pytest.approx(5.0, rel=1e-12)
    assert books["emitted"] == pytest.approx(books["left"] + books["inside"], rel=1e-12)
    assert record["iterations"] == 34  # twice the longest side


def test_run_writes_a_labelled_file_that_holds_the_field(tmp_path):
    _good(flatland("run", "two-walls", "--iterations", 5, "-o", "a.nc", cwd=tmp_path))
    data = load_dataset(tmp_path / "a.nc")
    assert data["accumulated"].dims == ("coefficient", "x", "y")
    assert float(np.abs(data["accumulated"]).max()) > 0


def test_options_reach_the_scheme():
    arguments = ("run", "fig5-one-light", "--iterations", 1, "--json", "--option")
    record = json.loads(_good(flatland(*arguments, "normalization=published")))
    assert record["ledger"]["created"] == pytest.approx(5 * (1 / (2 * np.pi) - 1), rel=1e-12)


def test_run_against_the_reference_prints_every_error():
    record = json.loads(_good(flatland("run", "fig5-one-light", "--reference", "--json")))
    assert 0 < record["errors"]["floor"] <= record["errors"]["angular"]


def test_walls_are_read_as_the_options_say(tmp_path):
    scene = (
        "[grid]\nshape = [8, 8]\n"
        "[[light]]\nkind = 'area'\nstart = [2, 1]\nend = [6, 1]\nflux = 1\n"
        "[[occluder]]\nkind = 'segment'\nstart = [1, 6]\nend = [7, 6]\nalbedo = 0.5\n"
    )
    (tmp_path / "a.toml").write_text(scene)
    run = ("run", "a.toml", "--json", "--blocking")
    books = {}
    for options in (
        ("exact",),
        ("exact", "--no-bounces"),
        ("exact", "--lights-block"),
        ("fuzzy",),
        ("fuzzy", "--strength", 2),
        ("none",),
    ):
        record = json.loads(_good(flatland(*run, *options, cwd=tmp_path)))
        books[options] = record["ledger"]["absorbed"], record["ledger"]["reflected"]
    assert len(set(books.values())) == len(books)
    assert books["none",] == (0.0, 0.0)
    assert books["exact", "--no-bounces"][1] == 0.0
    assert all(books[key][1] > 0 for key in books if key[-1] not in ("none", "--no-bounces"))


def test_the_exact_answer_has_no_error_but_the_floor():
    record = json.loads(
        _good(flatland("run", "shelf", "--propagator", "analytic", "--reference", "--json"))
    )
    assert record["errors"]["coefficients"] == 0.0
    # The floor is the best fit to 256 samples, the coefficients are exact: they differ by the
    # sampling error of kinks.
    assert record["errors"]["angular"] == pytest.approx(record["errors"]["floor"], rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "fig5-one-ligth"], ["fig5-one-ligth", "fig5-one-light"]),
        (["run", "two-walls", "--propagator", "lvp"], ["lvp", "lpv", "dom8"]),
        (["run", "two-walls", "--option", "flux=exact"], ["flux", "exact", "transfer", "central"]),
        (["run", "two-walls", "--option", "flux"], ["--option", "key=value"]),
        (["run", "two-walls", "--option", "colour=red"], ["colour", "flux"]),
        (["run", "two-walls", "--bands", "0"], ["bands", "0"]),
        (["run", "two-walls", "--bands", "two"], ["bands", "two"]),
        (["run", "two-walls", "--precision", "half"], ["precision", "half", "float32"]),
        (["run", "two-walls", "--blocking", "soft"], ["blocking", "soft", "exact", "fuzzy"]),
        (["run", "two-walls", "--blocking", "fuzzy", "--strength", "-1"], ["strength", "-1"]),
        (["run", "two-walls", "--iterations", "-1"], ["iterations", "-1"]),
        (["run", "two-walls", "--converge", "2"], ["converge", "2"]),
        (["run", "two-walls", "--iterations", "3", "--converge", "1e-3"], ["together"]),
        (["compare", "two-walls", "--bands", "2,x"], ["--bands", "2,x"]),
        (["compare", "two-walls", "-o", "picture.gif"], ["picture.gif", ".png"]),
        (["compare", "two-walls", "--propagator", "dom9"], ["dom9", "dom8"]),
        (["figure", "clpv-fig6"], ["clpv-fig6", "clpv-fig5"]),
        (["nonsense"], ["nonsense"]),
        (["run"], ["SCENE"]),
    ],
)
def test_a_mistake_is_named_with_the_choices(arguments, words, tmp_path):
    _refused(flatland(*arguments, cwd=tmp_path), *words)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_written_fails_with_its_name(tmp_path):
    (tmp_path / "folder").write_text("a file where a folder should be")
    process = flatland("run", "two-walls", "-o", tmp_path / "folder" / "a.nc")
    assert process.returncode == 1
    assert "a.nc" in process.stderr
    assert "Traceback" not in process.stderr


def test_an_unstable_scheme_warns_once_with_its_radius_and_a_way_out():
    arguments = ("run", "fig5-one-light", "--propagator", "dom4", "--bands", 3)
    process = flatland(*arguments, "--option", "emission=delta", "--iterations", 4)
    assert process.returncode == 0
    assert process.stderr.count("warning") == 1
    for word in ("1.2732", "dom4()"):
        assert word in process.stderr


def test_asking_an_unstable_scheme_for_its_answer_fails():
    arguments = ("run", "fig5-one-light", "--propagator", "dom4", "--bands", 3)
    process = flatland(*arguments, "--option", "emission=delta", "--converge", 1e-6)
    assert process.returncode == 1
    assert "1.2732" in process.stderr


def test_compare_prints_a_table_and_draws_the_picture_with_its_data(tmp_path):
    text = _good(flatland("compare", "fig5-one-light", "--bands", "2", "-o", "a.png", cwd=tmp_path))
    for word in ("lpv()", "dom4()", "dom8()", "floor", "leak"):
        assert word in text
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert load_dataset(tmp_path / "a.nc").sizes["scheme"] == 3


def test_compare_lists_what_did_not_run():
    arguments = ("compare", "fig5-one-light", "--bands", "3", "--json")
    process = flatland(*arguments, "--propagator", "dom4:emission=delta", "--propagator", "lpv")
    record = json.loads(process.stdout)
    assert [run["method"]["propagator"] for run in record["runs"]] == ["lpv"]
    assert "1.2732" in record["failed"][0]["reason"]


def test_an_interrupted_run_leaves_no_file_and_no_traceback(tmp_path):
    arguments = ["run", "clutter:size=256", "--iterations", "100000000", "-o", "a.nc"]
    process = subprocess.Popen(
        [sys.executable, "-c", _MAIN, *arguments],
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        start_new_session=True,
    )
    time.sleep(4)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "interrupted" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


def test_a_sun_has_no_angular_error_and_the_json_stays_json():
    text = _good(flatland("run", "atrium", "--iterations", 2, "--reference", "--json"))
    errors = json.loads(text, parse_constant=pytest.fail)["errors"]
    assert errors["angular"] is None
    assert errors["coefficients"] > 0


def test_run_explains_what_it_skipped_and_what_it_took():
    told = _good(flatland("run", "fig5-one-light", "--iterations", "4", "--explain"))
    assert "operations a cell instead of" in told
    assert "memory: source, target and accumulated light take" in told
    record = json.loads(_good(flatland("run", "fig5-one-light", "--iterations", "4", "--json")))
    assert record["memory"]["fields"] > 3 * 3 * 8 * 17**2
