"""The records of a study as one tidy data set."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from flatland.results import versions, write_atomically
from flatland.scene import scene_to_toml
from studies.kinds import find_kind
from studies.kinds.base import Column
from studies.sweeps.case import Case
from studies.sweeps.code import code_version
from studies.sweeps.store import DONE, FAILED, Record
from studies.sweeps.study import Study

Row = dict[str, Any]

#: Columns of every kind.
COMMON = {
    "case": Column(str, "key of the case: the name of its file"),
    "kind": Column(str, "what the case computed"),
    "status": Column(str, "done, or failed with a reason"),
    "reason": Column(str, "why it failed"),
    "warnings": Column(str, "what it was warned of"),
    "case_seconds": Column(float, "the whole case with all it prepared", "s"),
    "peak_memory": Column(float, "by how much the process grew", "B"),
    "code": Column(str, "version and fingerprint of the code"),
    "versions": Column(str, "of the libraries, as JSON"),
    "machine": Column(str, "that it ran on, as JSON"),
}
#: Columns that differ from run to run of the same study: times, memory and where it was.
VOLATILE = (
    "case_seconds",
    "peak_memory",
    "versions",
    "machine",
    "seconds",
    "seconds_low",
    "seconds_high",
    "first_seconds",
    "setup_seconds",
)
_BLANK = {str: "", int: -1, float: math.nan, bool: False}


def study_dataset(study: Study, cases: Sequence[Case], records: Sequence[Record]) -> xr.Dataset:
    """One row per case and stop, in the study's order; a failed case has a row with its reason.

    Coordinate `row` is CASE.NUMBER. Numbers a row does not have are NaN, whole ones -1, texts
    empty. The attributes hold the study, its scenes and the versions.
    """
    rows = [row for case, record in zip(cases, records) for row in _rows(case, record)]
    columns = _columns(cases)
    present = [name for name in columns if name in COMMON or any(name in row for row in rows)]
    data = xr.Dataset(coords={"row": [row["row"] for row in rows]})
    for name in present:
        column = columns[name]
        values = [row.get(name) for row in rows]
        dims, array = _array(column, values)
        attrs = {"long_name": column.meaning, **({"units": column.unit} if column.unit else {})}
        data[name] = (dims, array, attrs)
    data.attrs = {
        "title": study.title,
        "study": study.to_toml(),
        "scenes": json.dumps(_scenes(cases), sort_keys=True),
        "code": code_version(),
        "versions": json.dumps(versions(), sort_keys=True),
        "volatile": " ".join(name for name in VOLATILE if name in present),
    }
    return data


def write_csv(data: xr.Dataset, path: Path) -> Path:
    """The same rows for a spreadsheet: a line each, lists as one column per band."""
    names: dict[str, Any] = {"row": data["row"].values}
    for name, array in data.data_vars.items():
        if array.ndim == 1:
            names[str(name)] = array.values
        else:
            names |= {f"{name}_{i}": array.values[:, i] for i in range(array.shape[1])}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(zip(*(map(_shown, column) for column in names.values())))
    return write_atomically(path, lambda place: place.write_text(text.getvalue(), "utf-8"))


def stable_part(data: xr.Dataset) -> xr.Dataset:
    """The data set without what differs from run to run: times, memory, machines."""
    return data.drop_vars([name for name in VOLATILE if name in data])


def _rows(case: Case, record: Record) -> list[Row]:
    """Rows of one case, that of its failure last."""
    found = [{**row, "status": DONE} for row in record.rows]
    if record.status == FAILED:
        described = find_kind(case.kind).describe(case)
        found.append({**described, "status": FAILED, "reason": record.reason})
    common = {
        "case": record.key,
        "kind": case.kind,
        "warnings": "; ".join(record.warnings),
        "case_seconds": record.seconds,
        "peak_memory": float(record.peak_memory) if record.peak_memory >= 0 else math.nan,
        "code": record.code,
        "versions": json.dumps(record.versions, sort_keys=True),
        "machine": json.dumps(record.machine, sort_keys=True),
    }
    return [{"row": f"{record.key}.{i}", **common, **row} for i, row in enumerate(found)]


def _columns(cases: Sequence[Case]) -> dict[str, Column]:
    kinds = dict.fromkeys(case.kind for case in cases)
    own = {name: column for kind in kinds for name, column in find_kind(kind).columns.items()}
    return {**COMMON, **own}


def _array(column: Column, values: Sequence[Any]) -> tuple[tuple[str, ...], np.ndarray]:
    if column.type is list:
        width = max((len(value) for value in values if value), default=0)
        array = np.full((len(values), width), np.nan)
        for row, value in zip(array, values):
            row[: len(value or ())] = value or ()
        return ("row", "band"), array
    blank = _BLANK[column.type]
    filled = [blank if value is None else value for value in values]
    kind = {str: object, int: np.int64, float: np.float64, bool: bool}[column.type]
    return ("row",), np.array(filled, dtype=kind)


def _scenes(cases: Sequence[Case]) -> Mapping[str, str]:
    """The TOML of every scene by the digest that rows name."""
    scenes = {case.scene.digest[:12]: case.scene for case in cases if case.scene}
    return {digest: scene_to_toml(scene.load()) for digest, scene in scenes.items()}


def _shown(value: Any) -> str:
    """Numbers in full, what is missing as nothing."""
    if isinstance(value, float | np.floating):
        return "" if value != value else repr(float(value))
    return str(value)
