"""What a user waits for before anything happens."""

from __future__ import annotations

import subprocess
import sys

from studies.bench.limits import best_seconds


def _run(*arguments: str) -> None:
    code = "from studies.command_line import main; main()"
    subprocess.run([sys.executable, "-c", code, *arguments], check=True, capture_output=True)


def test_help_answers_at_once(report):
    seconds = best_seconds(lambda: _run("--help"), 5)
    report(f"flatland --help: {seconds:.2f} s")
    assert seconds < 0.5


def test_run_starts_quickly(report):
    seconds = best_seconds(lambda: _run("run", "fig5-one-light"), 5)
    report(f"flatland run fig5-one-light: {seconds:.2f} s")
