"""Running studies: every case once, failures recorded, numbers that can be had again."""

from __future__ import annotations

import csv
import json
import shlex

import numpy as np
import pytest
import xarray as xr
from small_studies import Silent, every_builtin_study, run_here, small_dataset, study_of

import propagators
from flatland.results import load_dataset
from studies.command_line import _run
from studies.kinds import field_errors, find_kind
from studies.sweeps import references
from studies.sweeps.case import Case
from studies.sweeps.store import DONE, FAILED
from studies.sweeps.table import COMMON, stable_part
from studies.sweeps.work import run_case

SWEEP = {"scenes": "tiny", "propagators": ["lpv", "dom8"], "bands": [1, 2], "converge": 1e-6}
#: DOM4 with peaks and three bands has no converged field.
UNSTABLE = {**SWEEP, "propagators": ["lpv", "dom4:emission=delta"], "bands": 3}


@pytest.fixture(autouse=True)
def no_references_in_memory():
    references._recent.clear()


@every_builtin_study
def test_a_small_version_of_every_study_runs(name):
    data = load_dataset(small_dataset(name))
    assert set(data["status"].values) == {DONE}
    known = {name for kind in set(data["kind"].values) for name in find_kind(kind).columns}
    assert set(data.data_vars) <= known | set(COMMON)
    assert all(array.attrs["long_name"] for array in data.data_vars.values())


def test_a_second_run_computes_nothing_and_gives_the_same_data_set(tmp_path):
    study = study_of(SWEEP)
    first = run_here(study, tmp_path)
    before = load_dataset(first.dataset)
    watcher = Silent()
    again = run_here(study, tmp_path, watcher)
    assert (again.done, again.kept, watcher.finished_cases) == (0, 4, [])
    xr.testing.assert_identical(load_dataset(again.dataset), before)


def test_two_runs_agree_in_all_but_times(tmp_path):
    found = []
    for folder in ("a", "b"):
        references._recent.clear()
        found.append(load_dataset(run_here(study_of(SWEEP), tmp_path / folder).dataset))
    xr.testing.assert_identical(*(stable_part(data) for data in found))


def test_a_study_that_grows_computes_what_is_new(tmp_path):
    run_here(study_of(SWEEP), tmp_path)
    outcome = run_here(study_of({**SWEEP, "bands": [1, 2, 3]}), tmp_path)
    assert (outcome.done, outcome.kept) == (2, 4)


def test_a_failed_case_is_recorded_with_its_reason_and_stops_no_other(tmp_path):
    outcome = run_here(study_of(UNSTABLE), tmp_path)
    assert outcome.done == 1
    ((case, reason),) = outcome.failed
    assert case.parameters["propagator"] == "dom4"
    assert "1.2732" in reason
    data = load_dataset(outcome.dataset)
    failed = data.isel(row=int(np.flatnonzero(data["status"] == FAILED)[0]))
    assert "1.2732" in str(failed["reason"].values)
    assert (str(failed["scene"].values), int(failed["bands"])) == ("tiny", 3)
    assert np.isnan(failed["coefficients"])


@pytest.mark.parametrize(("retry", "runs"), [(True, 1), (False, 0)])
def test_failed_cases_are_tried_again_unless_told_otherwise(tmp_path, retry, runs):
    run_here(study_of(UNSTABLE), tmp_path)
    watcher = Silent()
    outcome = run_here(study_of(UNSTABLE), tmp_path, watcher, retry=retry)
    assert len(watcher.finished_cases) == runs
    assert len(outcome.failed) == 1


def test_stops_before_a_failure_are_kept(tmp_path):
    sweep = {
        "scenes": "tiny",
        "propagators": "lpv:propagation_factor=9",
        "iterations": [1, 2, 4000],
    }
    data = load_dataset(run_here(study_of(sweep), tmp_path).dataset)
    assert list(data["status"].values) == [DONE, DONE, FAILED]
    assert list(data["iterations"].values) == [1, 2, -1]
    assert "grown by a factor" in str(data["reason"].values[-1])


def test_a_fault_of_the_code_is_a_failed_case_with_its_traceback(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr(field_errors, "measure", broken)
    (case,) = study_of({"scenes": "tiny"}).cases()
    record = run_case(case.as_dict())
    assert (record.status, record.reason) == (FAILED, "ZeroDivisionError: a fault")
    assert "in broken" in record.traceback


def test_an_error_below_the_floor_fails_the_case(monkeypatch):
    real = field_errors.measure

    def flattering(*fields):
        errors = real(*fields)
        return {**errors, "angular": errors["floor"] - 1e-6}

    monkeypatch.setattr(field_errors, "measure", flattering)
    (case,) = study_of({"scenes": "tiny"}).cases()
    record = run_case(case.as_dict())
    assert record.status == FAILED
    assert "below the floor" in record.reason


def test_no_scheme_beats_the_floor(tmp_path):
    """Nor does the exact answer, which touches it."""
    sweep = {"scenes": "tiny", "propagators": ["all", "analytic"], "bands": [1, 3]}
    outcome = run_here(study_of(sweep), tmp_path)
    assert not outcome.failed
    data = load_dataset(outcome.dataset)
    above = data["angular"] - data["floor"]
    assert float(above.min()) >= -1e-9
    exact = data["propagator"] == "analytic"
    assert float(above[exact].max()) < 1e-3 < float(above[~exact].min())


def test_warnings_are_kept_with_the_case(recwarn):
    (case,) = study_of(
        {"scenes": "tiny", "propagators": "dom4:emission=delta", "bands": 3, "iterations": 1}
    ).cases()
    record = run_case(case.as_dict())
    assert record.status == DONE
    assert len(record.warnings) == 1
    assert "1.2732" in record.warnings[0]
    assert not recwarn


def test_exact_answers_are_computed_once_for_all_cases_and_kept(tmp_path, monkeypatch):
    scheme, calls = propagators.find("analytic"), []
    real = scheme.solve
    monkeypatch.setattr(scheme, "solve", lambda *a, **k: calls.append(1) or real(*a, **k))
    run_here(study_of(SWEEP), tmp_path)
    assert len(calls) == 1
    references._recent.clear()
    stepped = {"scenes": "tiny", "bands": 2}
    run_here(study_of(stepped), tmp_path)
    assert len(calls) == 1
    run_here(study_of({**stepped, "bands": 4}), tmp_path)  # needs more bands than there are
    assert len(calls) == 2


def test_a_stored_exact_answer_is_the_computed_one(tmp_path):
    (case,) = study_of({"scenes": "tiny", "bands": 3, "iterations": 2}).cases()
    fresh = run_case(case.as_dict(), str(tmp_path)).rows
    references._recent.clear()
    assert list(tmp_path.glob("*.npz"))
    assert stripped(run_case(case.as_dict(), str(tmp_path)).rows) == stripped(fresh)


def stripped(rows):
    return [{k: v for k, v in row.items() if "seconds" not in k} for row in rows]


@pytest.mark.parametrize(
    "changes",
    [
        {"converge": 1e-6, "bands": 3},
        {"iterations": 5, "propagators": "lpv:flux=central,clamp=true", "precision": "float32"},
        {
            "blocking": "fuzzy",
            "strength": 1.5,
            "resolution": 2,
            "bounces": False,
            "lights_block": True,
        },
        {"propagators": "analytic", "bands": 2},
    ],
)
def test_the_command_of_a_row_computes_it_again(changes, tmp_path, capsys, monkeypatch):
    """Also for a scene that lives in the study alone."""
    data = load_dataset(
        run_here(study_of({"scenes": ["tiny", "two-walls"], **changes}), tmp_path).dataset
    )
    monkeypatch.chdir(tmp_path)
    for row in range(data.sizes["row"]):
        words = shlex.split(str(data["command"].values[row]))
        assert words[0] == "flatland"
        assert _run([*words[1:], "--json"]) == 0
        errors = json.loads(capsys.readouterr().out)["errors"]
        for name in ("coefficients", "angular", "floor", "leak", "best_scale"):
            assert float(data[name][row]) == pytest.approx(errors[name], rel=1e-12, abs=1e-14)


def test_the_scene_of_a_row_is_in_the_data_set(tmp_path):
    from flatland.scene import parse_scene

    study = study_of({"scenes": "tiny", "resolution": [1, 2]})
    data = load_dataset(run_here(study, tmp_path).dataset)
    scenes = json.loads(data.attrs["scenes"])
    shapes = [parse_scene(scenes[digest]).grid.shape for digest in data["scene_digest"].values]
    assert shapes == [(6, 5), (12, 10)]


def test_the_spreadsheet_holds_the_same_numbers(tmp_path):
    outcome = run_here(study_of(SWEEP), tmp_path)
    data = load_dataset(outcome.dataset)
    with outcome.csv.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["row"] for row in rows] == list(data["row"].values)
    assert [float(row["angular"]) for row in rows] == list(data["angular"].values)
    assert [row["scheme"] for row in rows] == list(data["scheme"].values)
    assert rows[0]["band_errors_1"] == ""  # one band only


def test_timed_cases_say_how_they_were_timed(tmp_path):
    sweep = {"scenes": "tiny", "iterations": [1, 3], "repeats": 3}
    data = load_dataset(run_here(study_of(sweep, {**sweep, "repeats": 0}), tmp_path).dataset)
    assert list(data["repeats"].values) == [3, 3, 0, 0]
    for name in ("seconds_low", "seconds", "seconds_high", "first_seconds", "setup_seconds"):
        assert np.all(data[name] > 0)
    assert np.all(data["seconds_low"] <= data["seconds"])
    assert np.all(data["seconds"] <= data["seconds_high"])
    timed = data.isel(row=slice(0, 2))
    assert float(timed["seconds_low"][1]) > float(timed["seconds_low"][0])
    machine = json.loads(str(data["machine"].values[0]))
    assert machine["threads"] == 1
    assert machine["processor"]


def test_a_worker_with_other_code_is_refused(tmp_path, monkeypatch):
    from flatland.errors import FlatlandError
    from studies.sweeps import work

    monkeypatch.setattr(work, "code_version", lambda: "0.0.1+old")
    with pytest.raises(FlatlandError, match=r"0\.0\.1\+old.*same version"):
        run_here(study_of({"scenes": "tiny"}), tmp_path)
    assert not list((tmp_path / "cases").iterdir())


def test_a_case_survives_the_journey_to_a_worker():
    for case in study_of(SWEEP).cases():
        again = Case.from_dict(json.loads(json.dumps(case.as_dict())))
        assert again.key == case.key
