"""How long a study takes: the bands of all built-in scenes of two dimensions."""

from __future__ import annotations

import time

from studies.progress import study_progress
from studies.sweeps.engines import Processes
from studies.sweeps.runner import run_study
from studies.sweeps.study import load_study

#: What it may take with compiled kernels [s]; compiling them for the first time comes on top.
_LIMIT = 180.0


def test_the_study_of_bands_takes_less_than_three_minutes_on_two_cores(tmp_path):
    study = load_study("bands")
    begin = time.perf_counter()
    with study_progress() as watcher:
        outcome = run_study(study, tmp_path, Processes(2), watcher)
    seconds = time.perf_counter() - begin
    print(f"\nstudy bands: {outcome.done} cases in {seconds:.0f} s with two processes")
    assert not outcome.failed
    assert seconds < _LIMIT
