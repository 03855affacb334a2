"""The floors of the house, and what its files promise."""

from __future__ import annotations

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

_ROOT = Path(__file__).parent.parent


def test_imports_point_one_way():
    process = subprocess.run(
        [str(Path(sys.executable).parent / "lint-imports")],
        cwd=_ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout


def test_every_module_says_what_it_is():
    silent = [
        str(path.relative_to(_ROOT))
        for package in ("flatland", "propagators", "studies", "gui")
        for path in (_ROOT / package).rglob("*.py")
        if not path.read_text(encoding="utf-8").lstrip().startswith(('"""', 'r"""'))
    ]
    assert silent == []


@pytest.mark.parametrize(
    "path", sorted((_ROOT / "benchmarks").glob("test_*.py")), ids=lambda p: p.stem
)
def test_benchmarks_find_what_they_import(path):
    """They are run by hand, and what they use may have moved meanwhile."""
    runpy.run_path(str(path))
