"""Where figures get their numbers from: studies, run in a folder of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import xarray as xr

from flatland.errors import FlatlandError
from flatland.results import load_dataset


class Workshop(Protocol):
    """Gives the data set of a built-in study."""

    def study(self, name: str) -> xr.Dataset: ...


class StudyFolder:
    """Runs studies in FOLDER/studies/NAME, where `flatland study -o` may have left some cases."""

    def __init__(self, folder: Path, jobs: int | None = None) -> None:
        self.folder, self.jobs = folder, jobs

    def study(self, name: str) -> xr.Dataset:
        """All rows. Raises FlatlandError if every case failed."""
        from studies.progress import study_progress
        from studies.sweeps.engines import local_engine
        from studies.sweeps.runner import run_study
        from studies.sweeps.study import load_study

        with study_progress() as watcher:
            place = self.folder / "studies" / name
            outcome = run_study(load_study(name), place, local_engine(self.jobs), watcher)
        if not outcome.done + outcome.kept:
            raise FlatlandError(f"study {name}: no case succeeded; first: {outcome.failed[0][1]}")
        return load_dataset(outcome.dataset)


def good_rows(data: xr.Dataset, **wanted: object) -> xr.Dataset:
    """Rows that are done and have these values in these columns; a list allows any of its values.

    Columns that are nothing but blank for them are left out.
    """
    chosen = data["status"].values == "done"
    for column, value in wanted.items():
        values = value if isinstance(value, list | tuple) else [value]
        chosen &= data[column].isin(values).values
    return data.isel(row=chosen)


def one_per(data: xr.Dataset, *columns: str) -> list[tuple[object, ...]]:
    """The different combinations of values in some columns, in their first order."""
    rows = zip(*(data[column].values.tolist() for column in columns))
    return list(dict.fromkeys(rows))
