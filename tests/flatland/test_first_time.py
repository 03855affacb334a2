"""Users are told when kernels are compiled, and only then."""

from __future__ import annotations

import os
import subprocess
import sys

import numba
import pytest

import flatland  # noqa: F401 - listens to the compiler
from flatland.first_time import NOTICE, when_compiling

_RUN = "from studies.command_line import main; main(['run', 'fig5-one-light', '--iterations', '1'])"


def test_a_call_comes_once_and_at_compiling():
    heard = []
    when_compiling(lambda: heard.append(1))
    functions = [numba.njit(lambda x, a=a: a * x) for a in (1, 2)]
    assert not heard
    for function in functions:
        function(1.0)
        function(2.0)
    assert heard == [1]


@pytest.mark.slow
def test_the_first_command_says_that_it_compiles_and_the_second_does_not(tmp_path):
    surroundings = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    told = [
        subprocess.run(
            [sys.executable, "-c", _RUN],
            env=surroundings,
            check=True,
            capture_output=True,
            text=True,
        ).stderr
        for _ in range(2)
    ]
    assert told[0].count(NOTICE) == 1
    assert NOTICE not in told[1]
