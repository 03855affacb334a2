"""How long a study takes: the bands of all built-in scenes of two dimensions."""

from __future__ import annotations

import os
import time

from studies.progress import study_progress
from studies.sweeps.engines import Processes
from studies.sweeps.runner import run_study
from studies.sweeps.study import load_study

#: What it may take with compiled kernels [s]; compiling them for the first time comes on top.
_LIMIT, _CORES = 180.0, 2


def test_the_study_of_bands_takes_less_than_three_minutes_on_two_cores(tmp_path):
    """By the clock, or by processor time where others keep the cores busy."""
    study = load_study("bands")
    begin, before = time.perf_counter(), os.times()
    with study_progress() as watcher:
        outcome = run_study(study, tmp_path, Processes(_CORES), watcher)
    seconds, after = time.perf_counter() - begin, os.times()
    spent = sum(after[:4]) - sum(before[:4])
    print(
        f"\nstudy bands: {outcome.done} cases in {seconds:.0f} s with {_CORES} processes, "
        f"{spent:.0f} s of processor time"
    )
    assert not outcome.failed
    assert min(seconds, spent / _CORES) < _LIMIT
