"""What a user waits for before anything happens."""

from __future__ import annotations

import os
import subprocess
import sys
import time

from studies.bench.limits import best_seconds


def _run(*arguments: str, **surroundings: str) -> None:
    code = "from studies.command_line import main; main()"
    subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env={**os.environ, **surroundings},
        check=True,
        capture_output=True,
    )


def test_help_answers_at_once(report):
    seconds = best_seconds(lambda: _run("--help"), 5)
    report(f"flatland --help: {seconds:.2f} s")
    assert seconds < 0.5


def test_run_starts_quickly_once_it_is_compiled(report, tmp_path):
    def run():
        _run("run", "fig5-one-light", NUMBA_CACHE_DIR=str(tmp_path))

    begin = time.perf_counter()
    run()
    first = time.perf_counter() - begin
    second = best_seconds(run, 5)
    report(f"flatland run fig5-one-light: {first:.2f} s with compiling, then {second:.2f} s")
    assert first < 15
    assert second < 1.5
