"""Benchmarks print ratios to limits taken in the same run, so that a noisy machine cancels out."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest


@pytest.fixture(scope="session")
def report() -> Callable[[str], None]:
    """Print a line of results, whatever pytest captures."""

    def show(line: str) -> None:
        sys.__stdout__.write(line + "\n")
        sys.__stdout__.flush()

    return show
