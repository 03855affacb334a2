"""Studies small enough for the fast tests."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path

import pytest

from studies.sweeps.engines import Serial
from studies.sweeps.runner import run_study
from studies.sweeps.study import Study, load_study

#: A scene of a few cells with a wall.
TINY = {
    "title": "Tiny",
    "grid": {"shape": [6, 5]},
    "light": [{"kind": "area", "start": [1.0, 1.0], "end": [4.0, 1.0], "flux": 3.0}],
    "occluder": [{"kind": "segment", "start": [1.0, 3.0], "end": [3.5, 3.0]}],
}
#: What is changed in a study to make it small; where a sweep has the key.
SMALL = {
    "scenes": ["tiny"],
    "propagators": ["lpv", "dom8"],
    "bands": [1, 2],
    "resolution": [1, 2],
    "strength": [1.0, 2.0],
    "iterations": [0, 2, "2N"],
    "side": 4,
    "steps": 20,
    "converge": 1e-3,
    "repeats": 1,
}


def small(name):
    """A built-in study on the tiny scene."""
    study = load_study(name)
    known = {key for table in study.sweeps for key in table}
    changed = study.with_values({key: value for key, value in SMALL.items() if key in known})
    return Study(name, study.title, changed.sweeps, {"tiny": TINY})


def study_of(*sweeps, **scenes):
    return Study("try", "A try", sweeps, {"tiny": TINY, **scenes})


class Silent:
    """Hears how a run goes, and remembers it."""

    def __init__(self):
        self.said, self.finished_cases, self.counts = [], [], None

    def begin(self, total, kept):
        self.counts = total, kept

    def stage(self, name):
        pass

    def finished(self, case, record):
        self.finished_cases.append((case, record))

    def say(self, text):
        self.said.append(text)


def run_here(study, folder, watcher=None, **options):
    """Run a study in this process."""
    return run_study(study, folder, Serial(), watcher or Silent(), **options)


@cache
def small_dataset(name):
    """The data set file of a small built-in study, run once for all tests of a process."""
    folder = Path(tempfile.mkdtemp(prefix="small-study-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    outcome = run_here(small(name), folder)
    assert [reason for _, reason in outcome.failed] == []
    assert outcome.done == len(small(name).cases()) > 0
    return outcome.dataset


NAMES = ("bands", "blocking", "energy", "growth", "iterations", "pareto", "resolution", "stability")
every_builtin_study = pytest.mark.parametrize("name", NAMES)
