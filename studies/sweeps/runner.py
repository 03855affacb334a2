"""Running a study: what is missing is computed, what is there is kept."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from flatland.errors import FlatlandError, ResultFileError
from flatland.results import save_dataset, write_atomically
from flatland.scene import Scene, scene_to_toml
from studies.sweeps.case import Case
from studies.sweeps.code import code_version
from studies.sweeps.engines import Death, Engine, Processes, Serial, Task, drive
from studies.sweeps.references import has_reference
from studies.sweeps.store import DONE, FAILED, CaseStore, Record
from studies.sweeps.study import Study
from studies.sweeps.table import study_dataset, write_csv
from studies.sweeps.work import prepare_reference, run_case


class Watcher(Protocol):
    """Who is told how a run goes."""

    def begin(self, total: int, kept: int) -> None:
        """So many cases are to be run, so many are finished already."""

    def stage(self, name: str) -> None:
        """What begins now."""

    def finished(self, case: Case, record: Record) -> None:
        """One more case has an answer."""

    def say(self, text: str) -> None:
        """Something worth knowing."""


@dataclass
class Outcome:
    """What came of a run. kept: cases that were finished before. failed: with their reasons."""

    dataset: Path
    csv: Path
    done: int = 0
    kept: int = 0
    failed: list[tuple[Case, str]] = field(default_factory=list)


def run_study(
    study: Study,
    folder: Path,
    engine: Engine,
    watcher: Watcher,
    retry: bool = True,
) -> Outcome:
    """Run every case that has no good file yet, and write the data set of all of them.

    retry: whether cases that failed before are run again. Timed cases come last, one at a time, in
    a process of this machine, when nothing else of the study runs. The folder then holds
    study.toml, the study; cases/, a file each; references/, the exact answers they share; scenes/,
    its own scenes; study.nc and study.csv, the data set.
    Raises InputError for a wrong study, ResultFileError for a folder that cannot be written.
    """
    cases = study.cases()
    store = CaseStore(folder)
    _make(folder)
    with store.exclusive():
        store.prepare()
        _write_study(study, cases, folder)
        pending, outcome = _what_is_missing(cases, store, watcher, retry)
        outcome.dataset, outcome.csv = folder / "study.nc", folder / "study.csv"
        watcher.begin(len(pending), outcome.kept)
        _Run(store, watcher, outcome).everything(pending, engine)
        data = study_dataset(study, cases, [_stored(store, case) for case in cases])
        save_dataset(data, outcome.dataset)
        write_csv(data, outcome.csv)
    return outcome


@dataclass
class _Run:
    """The runs of one call, from references to timed cases."""

    store: CaseStore
    watcher: Watcher
    outcome: Outcome

    def everything(self, pending: Sequence[Case], engine: Engine) -> None:
        folder = self.store.folder / "references"
        wanted = _references(pending, str(folder))
        if wanted:
            _make(folder)
            self.watcher.stage("exact answers")
            with closing(drive(engine, wanted)) as answers:
                for _ in answers:
                    pass
        self._cases([case for case in pending if not case.timed], engine, "cases")
        timed = [case for case in pending if case.timed]
        alone = Serial() if isinstance(engine, Serial) else Processes(1)
        self._cases(timed, alone, "timed cases, one at a time")

    def _cases(self, cases: Sequence[Case], engine: Engine, stage: str) -> None:
        if not cases:
            return
        self.watcher.stage(stage)
        known = {case.key: case for case in cases}
        references = str(self.store.folder / "references")
        tasks = [Task(case.key, run_case, (case.as_dict(), references)) for case in cases]
        with closing(drive(engine, tasks)) as answers:
            for task, answer in answers:
                self._finish(known[task.key], answer)

    def _finish(self, case: Case, answer: Any) -> None:
        if isinstance(answer, Death):
            record = Record(case.key, FAILED, reason=answer.reason, code=code_version())
        else:
            record = answer
        _require_same_code(case, record)
        self.store.write(record)
        if record.status == FAILED:
            self.outcome.failed.append((case, record.reason))
        else:
            self.outcome.done += 1
        self.watcher.finished(case, record)


def _what_is_missing(
    cases: Iterable[Case], store: CaseStore, watcher: Watcher, retry: bool
) -> tuple[list[Case], Outcome]:
    """Cases to run; and those that are not, counted."""
    pending, outcome = [], Outcome(store.folder, store.folder)
    for case in cases:
        try:
            record = store.read(case.key)
        except ResultFileError as error:
            watcher.say(f"{error}; the case is computed again")
            record = None
        if record is None or (retry and record.status != DONE):
            pending.append(case)
        elif record.status == FAILED:
            outcome.failed.append((case, record.reason))
        else:
            outcome.kept += 1
    return pending, outcome


def _references(cases: Iterable[Case], folder: str) -> list[Task]:
    """One task for each exact answer that is not there yet, for the most bands that are asked."""
    wanted: dict[tuple[str, bool], Case] = {}
    for case in cases:
        if case.scene is None or not case.parameters.get("reference"):
            continue
        name = case.scene.digest, bool(case.parameters["bounces"])
        if name not in wanted or case.parameters["bands"] > wanted[name].parameters["bands"]:
            wanted[name] = case
    return [
        Task(f"{digest} {bounces}", prepare_reference, (case.as_dict(), folder))
        for (digest, bounces), case in wanted.items()
        if case.scene and not has_reference(case.scene, bounces, case.parameters["bands"], folder)
    ]


def _stored(store: CaseStore, case: Case) -> Record:
    record = store.read(case.key)
    assert record is not None
    return record


def _require_same_code(case: Case, record: Record) -> None:
    if record.code != code_version() or record.key != case.key:
        rule = f"{case.label}: the worker runs {record.code}, this is {code_version()}"
        raise FlatlandError(f"{rule}; install the same version everywhere")


def _write_study(study: Study, cases: Iterable[Case], folder: Path) -> None:
    """The declaration, and the scenes that live nowhere else."""
    text = study.to_toml()
    write_atomically(folder / "study.toml", lambda place: place.write_text(text, "utf-8"))
    for name in {case.scene.name for case in cases if case.scene} & set(study.scenes):
        shown = scene_to_toml(Scene.from_dict(study.scenes[name]))
        path = folder / "scenes" / f"{name}.toml"
        write_atomically(path, lambda place, shown=shown: place.write_text(shown, "utf-8"))


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{folder}: cannot be made: {error.strerror or error}"
        raise ResultFileError(message) from None
