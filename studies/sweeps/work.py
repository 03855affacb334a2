"""What a worker does with a case: run it, catch what goes wrong, and say what it cost."""

from __future__ import annotations

import os
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from typing import Any

from flatland.errors import FlatlandError
from flatland.results import versions
from studies.kinds import find_kind
from studies.machine import MemoryMeter, describe_machine
from studies.sweeps.case import Case
from studies.sweeps.code import code_version
from studies.sweeps.store import DONE, FAILED, Record

#: A reason longer than this says no more.
_LONGEST_REASON = 2000


def run_case(values: Mapping[str, Any], references: str = "") -> Record:
    """The record of a case, whatever happens to it.

    values: as `Case.as_dict` gives them. references: folder of shared exact answers, or "".
    Rows that were finished before a failure are kept; warnings are kept and not shown.
    """
    os.environ.setdefault("FLATLAND_THREADS", "1")
    case = Case.from_dict(values)
    record: dict[str, Any] = {"key": case.key, "status": DONE, "rows": []}
    begin, memory = time.perf_counter(), MemoryMeter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            kind = find_kind(case.kind)
            common = kind.describe(case)
            for row in kind.rows(case, references):
                record["rows"].append({**common, **row})
        except Exception as error:  # noqa: BLE001 - a failed case is a result like others
            record |= {"status": FAILED, "reason": _reason(error)}
            record["traceback"] = traceback.format_exc()
    return Record(
        **record,
        warnings=list(dict.fromkeys(str(each.message) for each in caught)),
        code=code_version(),
        versions=versions(),
        machine=describe_machine(),
        seconds=time.perf_counter() - begin,
        peak_memory=memory.peak(),
    )


def prepare_reference(values: Mapping[str, Any], references: str) -> None:
    """Compute and keep the exact answer that a case needs, so that cases find it.

    Errors are left to the cases, which meet and record them.
    """
    os.environ.setdefault("FLATLAND_THREADS", "1")
    from studies.sweeps.references import shared_reference

    scene = Case.from_dict(values).scene
    assert scene is not None
    parameters = values["parameters"]
    try:
        shared_reference(scene, parameters["bounces"], parameters["bands"], references)
    except Exception:  # noqa: BLE001
        return


def _reason(error: Exception) -> str:
    """One line for people; what is not the project's own error says its type."""
    text = str(error) or "no message"
    named = text if isinstance(error, FlatlandError) else f"{type(error).__name__}: {text}"
    return named[:_LONGEST_REASON]


#: A call that an engine runs elsewhere.
Call = Callable[..., Any]
