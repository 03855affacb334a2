"""Case files: whole or not there, and never believed when damaged."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from small_studies import Silent, run_here, study_of

from flatland.errors import InputError, ResultFileError
from studies.sweeps import runner, store
from studies.sweeps.store import CaseStore, Record

RECORD = Record(
    "abc",
    "done",
    rows=[{"error": 0.1 + 0.2, "nothing": math.nan, "far": math.inf, "name": "lpv", "bands": 2}],
    seconds=1.5,
)
SWEEP = {"scenes": "tiny", "bands": [1, 2], "iterations": 2}


@pytest.fixture
def kept(tmp_path):
    case_store = CaseStore(tmp_path)
    case_store.prepare()
    case_store.write(RECORD)
    return case_store


def test_a_record_comes_back_bit_for_bit(kept):
    found = kept.read("abc")
    (row,), (expected,) = found.rows, RECORD.rows
    assert math.isnan(row.pop("nothing"))
    assert row == {name: value for name, value in expected.items() if name != "nothing"}
    assert dataclasses.replace(found, rows=[]) == dataclasses.replace(RECORD, rows=[])


def test_there_is_no_record_of_a_case_that_was_not_run(kept):
    assert kept.read("xyz") is None


def test_cases_that_are_done_are_counted_by_their_files(kept):
    kept.write(dataclasses.replace(RECORD, key="failed", status="failed", reason="no light"))
    kept.path("damaged").write_text("{", encoding="utf-8")
    assert kept.count(["abc", "failed", "damaged", "missing"]) == 1


def test_a_file_cut_short_anywhere_is_damaged(kept):
    path = kept.path("abc")
    content = path.read_bytes()
    for length in range(len(content)):
        path.write_bytes(content[:length])
        with pytest.raises(ResultFileError, match=r"abc\.json: is damaged"):
            kept.read("abc")


def test_a_file_with_one_digit_changed_is_damaged(kept):
    path = kept.path("abc")
    path.write_text(path.read_text().replace("0.30000000000000004", "0.3000000000000001"))
    with pytest.raises(ResultFileError, match="checksum"):
        kept.read("abc")


def test_the_file_of_another_case_is_refused(kept):
    kept.path("abd").write_bytes(kept.path("abc").read_bytes())
    with pytest.raises(ResultFileError, match="holds case abc"):
        kept.read("abd")


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"null", b"\x00\xff", b"[" * 100_000])
def test_a_file_that_is_no_record_is_damaged(kept, content):
    kept.path("abc").write_bytes(content)
    with pytest.raises(ResultFileError, match="is damaged"):
        kept.read("abc")


def test_a_damaged_file_is_named_and_computed_again(tmp_path):
    study = study_of(SWEEP)
    run_here(study, tmp_path)
    first, _ = sorted((tmp_path / "cases").iterdir())
    content = first.read_bytes()
    first.write_bytes(content[: len(content) // 2])
    watcher = Silent()
    outcome = run_here(study, tmp_path, watcher)
    assert (outcome.done, outcome.kept) == (1, 1)
    (said,) = watcher.said
    assert str(first) in said
    assert "computed again" in said
    assert CaseStore(tmp_path).read(first.stem).status == "done"


def test_a_damaged_exact_answer_is_computed_again(tmp_path):
    from studies.sweeps import references

    references._recent.clear()  # that of another test may have more bands
    study = study_of(SWEEP)
    before = run_here(study, tmp_path)
    (answer,) = (tmp_path / "references").iterdir()
    content, exact = answer.read_bytes(), arrays_of(answer)
    answer.write_bytes(content[:-200] + b"x" * 200)
    for path in (tmp_path / "cases").iterdir():
        path.unlink()
    references._recent.clear()
    assert run_here(study, tmp_path).done == before.done
    again = arrays_of(answer)
    assert again.keys() == exact.keys()
    for name, values in again.items():
        np.testing.assert_allclose(values, exact[name], rtol=1e-12, atol=1e-14)


def arrays_of(path):
    with np.load(path) as found:
        return dict(found)


def test_half_written_files_of_a_killed_run_are_removed(tmp_path):
    study = study_of(SWEEP)
    run_here(study, tmp_path)
    for rest in (tmp_path / "cases" / ".abc-x1y2z3.json", tmp_path / ".study-a1b2.nc"):
        rest.write_text("half")
    run_here(study, tmp_path)
    assert not list(tmp_path.rglob(".*"))


def test_two_runs_never_share_a_folder(tmp_path):
    case_store = CaseStore(tmp_path)
    with case_store.exclusive(), pytest.raises(InputError, match="in use"):
        run_here(study_of(SWEEP), tmp_path)
    assert run_here(study_of(SWEEP), tmp_path).done == 2


def test_a_full_disk_ends_the_run_with_no_half_file(tmp_path, monkeypatch):
    real, written = store.write_atomically, []

    def write(path, how):
        def full(place):
            how(place)
            raise OSError(28, "No space left on device")

        written.append(path)
        return real(path, full if len(written) == 2 else how)

    monkeypatch.setattr(store, "write_atomically", write)
    study = study_of({**SWEEP, "bands": [1, 2, 3]})
    with pytest.raises(ResultFileError, match=r"cases/\w+\.json: cannot be written: No space left"):
        run_here(study, tmp_path)
    files = list((tmp_path / "cases").iterdir())
    assert len(files) == 1
    assert CaseStore(tmp_path).read(files[0].stem).status == "done"
    assert not (tmp_path / "study.nc").exists()
    outcome = run_here(study, tmp_path)
    assert (outcome.done, outcome.kept) == (2, 1)


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ResultFileError, match="file/deep"):
        run_here(study_of(SWEEP), tmp_path / "file" / "deep")


def test_a_folder_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    """As on a read-only file system; whoever runs as root may write anywhere."""

    def refuse(self, *_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(tmp_path), "open", refuse)
    with pytest.raises(ResultFileError, match=f"{tmp_path}: cannot be written: Permission denied"):
        run_here(study_of(SWEEP), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_data_set_that_cannot_be_written_leaves_the_cases(tmp_path, monkeypatch):
    def full(*_):
        raise ResultFileError("study.nc: cannot be written: No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(runner, "save_dataset", full)
        with pytest.raises(ResultFileError, match="No space left"):
            run_here(study_of(SWEEP), tmp_path)
    assert run_here(study_of(SWEEP), tmp_path).kept == 2
