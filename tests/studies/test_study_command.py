"""`flatland study` and `flatland bench` as their users meet them."""

from __future__ import annotations

import json
import re

import pytest
from small_studies import TINY, study_of

from flatland.first_time import NOTICE
from flatland.results import load_dataset
from studies.bench import limits
from studies.command_line import _run
from studies.progress import study_progress
from studies.sweeps.store import CaseStore
from studies.sweeps.study import builtin_studies, load_study

SWEEP = {"scenes": "tiny", "propagators": ["lpv", "dom4:emission=delta"], "bands": [2, 3]}


@pytest.fixture
def study_file(tmp_path):
    path = tmp_path / "try.toml"
    path.write_text(study_of({**SWEEP, "converge": 1e-3}, tiny=TINY).to_toml(), encoding="utf-8")
    return str(path)


def refused(capsys, *arguments):
    assert _run(list(map(str, arguments))) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Traceback" not in captured.err
    return captured.err


@pytest.mark.parametrize("arguments", [["study"], ["study", "list"]])
def test_studies_are_listed(arguments, capsys):
    assert _run(arguments) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in builtin_studies())


def test_a_study_can_be_shown_and_changed(capsys):
    assert _run(["study", "bands", "--show", "--set", "bands=[2, 4]", "--set", "scenes=shelf"]) == 0
    shown = capsys.readouterr().out
    assert "bands = [2, 4]" in shown
    assert 'scenes = "shelf"' in shown


def test_a_study_with_failures_says_so_and_writes_its_data_set(study_file, tmp_path, capsys):
    folder = tmp_path / "out"
    assert _run(["study", study_file, "-o", str(folder), "--jobs", "1"]) == 1
    out, error = capsys.readouterr()
    assert "3 cases done, 0 kept, 1 failed" in out
    assert re.search(r"failed: errors: dom4, 3 bands, on tiny \(\w+\): .*1\.2732", out)
    # The first command of a process may have kernels to compile, and says so.
    assert all(NOTICE in line for line in error.splitlines())
    assert load_dataset(folder / "study.nc").sizes["row"] == 4
    assert (folder / "study.csv").read_text().count("\n") == 5


def test_a_study_goes_on_by_its_folder_alone(study_file, tmp_path, capsys):
    folder = str(tmp_path / "out")
    _run(["study", study_file, "-o", folder, "--jobs", "1"])
    capsys.readouterr()
    arguments = ["study", "--resume", "-o", folder, "--jobs", "1", "--keep-failed", "--json"]
    assert _run(arguments) == 1
    record = json.loads(capsys.readouterr().out)
    assert (record["done"], record["kept"], len(record["failed"])) == (0, 3, 1)
    assert "1.2732" in record["failed"][0]["reason"]


def test_an_interrupt_right_after_a_case_is_kept_counts_it(
    study_file, tmp_path, capsys, monkeypatch
):
    write = CaseStore.write

    def interrupted_write(store, record):
        write(store, record)
        raise KeyboardInterrupt

    monkeypatch.setattr(CaseStore, "write", interrupted_write)
    assert _run(["study", study_file, "-o", str(tmp_path / "out"), "--jobs", "1"]) == 130
    assert "interrupted; 1 of 4 cases are finished and kept" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["study", "band"], ["band", "bands", "pareto"]),
        (["study", "--resume"], ["--resume", "folder"]),
        (["study", "bands", "--jobs", "0"], ["--jobs = 0", "at least 1"]),
        (["study", "bands", "--set", "bands"], ["--set", "key=value"]),
        (["study", "bands", "--set", "colour=red"], ["'colour'", "bands"]),
        (["study", "bands", "--set", "bands=0", "-o", "x"], ["bands = 0", "sweep 1"]),
        (["bench", "--sizes", "0"], ["--sizes", "0"]),
        (["bench", "--propagator", "analytic"], ["analytic", "lpv", "steps"]),
        (["bench", "--precision", "half"], ["half", "float32"]),
    ],
)
def test_a_mistake_is_named_with_the_choices(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    error = refused(capsys, *arguments)
    for word in words:
        assert word in error
    assert list(tmp_path.iterdir()) == []


def test_a_terminal_sees_cases_done_failed_and_left(monkeypatch, capsys):
    class Record:
        status = "failed"

    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    with study_progress() as watcher:
        watcher.begin(4, kept=3)
        watcher.stage("cases")
        watcher.finished(None, Record())
        bar = watcher._bar
        text = "".join(str(column(bar.tasks[0])) for column in bar.columns[2:4])
        bar.refresh()
    assert "1/4" in text
    assert "1 failed" in text
    assert "cases" in capsys.readouterr().err


def test_a_pipe_sees_no_bar(capsys):
    with study_progress() as watcher:
        watcher.begin(4, kept=0)
        watcher.stage("cases")
        watcher.say("a word")
    assert capsys.readouterr() == ("", "flatland: a word\n")


def test_bench_prints_ratios_to_limits_of_the_same_run(capsys, monkeypatch):
    monkeypatch.setattr(limits, "LARGE", 64)
    limits.main_memory_bandwidth.cache_clear()
    arguments = ["bench", "--sizes", "8", "--sizes-3d", "4", "--bands", "1"]
    assert _run([*arguments, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    seen = {(row["scheme"], row["dimension"]) for row in record["rows"]}
    assert {("lpv", 2), ("lpv", 3), ("dom8", 2), ("dom26", 3)} <= seen
    for row in record["rows"]:
        assert row["seconds"] > 0
        assert row["over_same_arrays"] > 0
        assert row["over_main_memory"] > 0
        assert row["over_arithmetic"] > 0
        parts = ("over_main_memory", "over_same_arrays", "over_arithmetic")
        assert row["over_limit"] == pytest.approx(min(row[name] for name in parts))
    assert record["machine"]["threads"] == 1
    assert _run([*arguments, "--propagator", "lpv"]) == 0
    assert "x main memory" in capsys.readouterr().out
    limits.main_memory_bandwidth.cache_clear()


def test_the_built_in_studies_say_what_they_show():
    assert all(load_study(name).title for name in builtin_studies())
