"""Which code computes a case: numbers of other code are other numbers."""

from __future__ import annotations

import hashlib
import inspect
from functools import cache
from pathlib import Path

import flatland
import propagators
import studies
from flatland.results import versions
from propagators.registry import BUILT_IN

#: Raised when the meaning of a stored case changes, though no code below does.
SCHEMA = 1
#: What of `studies` a number goes through. Of `flatland` and `propagators` it is every module.
MEASURING = (
    "comparison.py",
    "kinds",
    "metrics.py",
    "reference.py",
    "running.py",
    "sweeps/references.py",
)


@cache
def code_version() -> str:
    """The package's version and a fingerprint of every source file that numbers depend on.

    Any edit counts, also one of a comment: a case too many is computed rather than one too few.
    """
    content = hashlib.sha256(str(SCHEMA).encode())
    for path in _sources():
        content.update(f"{path.parent.name}/{path.name}".encode())
        content.update(path.read_bytes())
    return f"{versions()['flatland']}+{content.hexdigest()[:12]}"


def foreign_code(name: str) -> str:
    """A fingerprint of the module of a propagator that another project offers; "" for ours."""
    if name in BUILT_IN:
        return ""
    source = inspect.getsourcefile(propagators.find(name))
    return hashlib.sha256(Path(source).read_bytes()).hexdigest()[:12] if source else "unknown"


def _sources() -> list[Path]:
    roots = [_home(flatland), _home(propagators), *(_home(studies) / part for part in MEASURING)]
    return [
        path for root in roots for path in ([root] if root.suffix else sorted(root.rglob("*.py")))
    ]


def _home(package: object) -> Path:
    return Path(str(inspect.getsourcefile(package))).parent  # type: ignore[arg-type]
