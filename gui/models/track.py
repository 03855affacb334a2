"""Curves over the iterations of a run: energy, and errors where the exact answer is known."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from gui.models.measures import ERRORS

#: Entries of the flux ledger that are drawn, with what they mean.
ENERGY = {
    "emitted": "injected into cells [W]",
    "left": "went out over the border [W]",
    "absorbed": "stopped by occluders and kept [W]",
    "inside": "newest light, still to move [W]",
    "created": "made (or, negative, lost) by the scheme itself [W]",
    "reflected": "sent back by occluders, every time anew [W]",
}


@dataclass(frozen=True)
class Row:
    """One iteration: energy entries, and errors or nothing."""

    iteration: int
    values: Mapping[str, float]


@dataclass
class Track:
    """All rows of one run, by iteration. label: the run's method, for legends."""

    label: str = ""
    rows: dict[int, Row] = field(default_factory=dict)
    #: Grows with every change, so that a view knows when to draw.
    version: int = 0

    def add(self, rows: Iterable[Row]) -> None:
        """Rows of new iterations, or of old ones with more values."""
        for row in rows:
            known = self.rows.get(row.iteration)
            values = {**known.values, **row.values} if known else row.values
            self.rows[row.iteration] = Row(row.iteration, values)
            self.version += 1

    def clear(self) -> None:
        self.rows.clear()
        self.version += 1

    def series(self, name: str) -> tuple[list[int], list[float]]:
        """Iterations and values of one entry, where it is known, in order."""
        points = [(i, row.values[name]) for i, row in self.rows.items() if name in row.values]
        points.sort()
        return [i for i, _ in points], [value for _, value in points]


def tracks_to_csv(tracks: Iterable[Track]) -> str:
    """One row per run and iteration; empty where a value is not known."""
    columns = [*ENERGY, *ERRORS]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "iteration", *columns])
    for track in tracks:
        for iteration in sorted(track.rows):
            values = track.rows[iteration].values
            cells = [repr(values[name]) if name in values else "" for name in columns]
            writer.writerow([track.label, iteration, *cells])
    return text.getvalue()
