"""Finished cases as files: one each, whole or not at all, with a checksum inside."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from flatland.errors import ResultFileError, bad_input
from flatland.results import write_atomically
from studies.sweeps.case import canonical

Row = dict[str, Any]

DONE, FAILED = "done", "failed"


@dataclass(frozen=True)
class Record:
    """What came of a case.

    rows: plain values by column. status: "done", or "failed" with a reason, and for people who
    look for the fault a traceback; rows that were finished before it are kept. versions, machine:
    of the worker. seconds: of the whole case, its preparation included. peak_memory: by how much
    the process grew meanwhile [B], -1 where the system does not tell.
    """

    key: str
    status: str
    rows: list[Row] = field(default_factory=list)
    reason: str = ""
    traceback: str = ""
    warnings: list[str] = field(default_factory=list)
    code: str = ""
    versions: dict[str, str] = field(default_factory=dict)
    machine: dict[str, Any] = field(default_factory=dict)
    seconds: float = math.nan
    peak_memory: int = -1


class CaseStore:
    """The folder of a study: cases/KEY.json for each finished case.

    Only the runner writes here, one process at a time (`exclusive`).
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cases = folder / "cases"

    def path(self, key: str) -> Path:
        return self.cases / f"{key}.json"

    def write(self, record: Record) -> None:
        """Keep a record. Raises ResultFileError naming the file and the reason."""
        body = _encoded(asdict(record))
        text = canonical({"checksum": _checksum(body), "record": body})
        write_atomically(self.path(record.key), lambda place: place.write_text(text, "utf-8"))

    def read(self, key: str) -> Record | None:
        """The record of a case, None if there is none.

        Raises ResultFileError naming the file if it is cut short, changed or another case's.
        """
        path = self.path(key)
        try:
            content = json.loads(path.read_bytes())
            body, checksum = content["record"], content["checksum"]
        except FileNotFoundError:
            return None
        except OSError as error:
            raise ResultFileError(f"{path}: cannot be read: {error.strerror or error}") from None
        except (ValueError, KeyError, TypeError, RecursionError):
            raise ResultFileError(f"{path}: is damaged: no record can be read") from None
        if _checksum(body) != checksum:
            raise ResultFileError(f"{path}: is damaged: its checksum does not fit")
        if body["key"] != key:
            raise ResultFileError(f"{path}: is damaged: it holds case {body['key']}")
        return Record(**_decoded(body))

    def count(self, keys: Iterable[str]) -> int:
        """How many of these cases are done, as the files tell."""
        return sum(self._is_done(key) for key in keys)

    def _is_done(self, key: str) -> bool:
        try:
            record = self.read(key)
        except ResultFileError:
            return False
        return record is not None and record.status == DONE

    def prepare(self) -> None:
        """Make the folder; remove what a killed runner left half written.

        Raises ResultFileError if nothing can be written here.
        """
        try:
            self.cases.mkdir(parents=True, exist_ok=True)
            for folder in (self.folder, self.cases):
                for rest in filter(Path.is_file, folder.glob(".?*-*.*")):
                    rest.unlink(missing_ok=True)
        except OSError as error:
            message = f"{self.folder}: cannot be written: {error.strerror or error}"
            raise ResultFileError(message) from None

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Keep other runners out of the folder. Raises InputError if one is in it.

        The lock dies with its process. Where the file system has no locks, nothing is locked.
        """
        try:
            file = (self.folder / "lock").open("a", encoding="utf-8")
        except OSError as error:
            message = f"{self.folder}: cannot be written: {error.strerror or error}"
            raise ResultFileError(message) from None
        with file:
            if not _locked(file.fileno()):
                rule = "is in use by another run of a study"
                raise bad_input("output", str(self.folder), rule)
            yield


def _locked(handle: int) -> bool:
    """Whether the lock is ours, or there are no locks here."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _checksum(body: Any) -> str:
    return hashlib.sha256(canonical(body).encode()).hexdigest()


def _encoded(value: Any) -> Any:
    """JSON has no NaN and no infinity: they become {"number": "nan"}."""
    if isinstance(value, float) and not math.isfinite(value):
        return {"number": str(value)}
    if isinstance(value, dict):
        return {name: _encoded(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_encoded(entry) for entry in value]
    return value


def _decoded(value: Any) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"number"}:
            return float(value["number"])
        return {name: _decoded(entry) for name, entry in value.items()}
    return [_decoded(entry) for entry in value] if isinstance(value, list) else value
