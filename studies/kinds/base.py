"""What a kind of case is: the keys a sweep may have, and the rows a case gives."""

from __future__ import annotations

import itertools
import json
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from flatland.errors import bad_input
from propagators import Option, Propagator, create
from studies.kinds.schemes import chosen_propagators
from studies.sweeps.case import Case
from studies.sweeps.code import foreign_code
from studies.sweeps.scenes import StudyScene, study_scenes

Row = dict[str, Any]


@dataclass(frozen=True)
class Column:
    """One column of the data set. type: str, int, float, bool or list (of floats, one per band)."""

    type: type
    meaning: str
    unit: str = ""


@dataclass(frozen=True)
class Point:
    """One point of a sweep: a scheme, a scene if the kind has scenes, a value on every axis."""

    propagator: Propagator
    scene: StudyScene | None
    values: Mapping[str, Any]


class Kind(ABC):
    """A kind of case.

    Subclasses declare `name`, `summary`, the swept `axes` (a key may hold one value or a list),
    the `columns` of their rows, and whether a case happens `on_scenes`.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    on_scenes: ClassVar[bool] = True
    axes: ClassVar[tuple[Option, ...]] = ()
    #: Keys whose list belongs to one case, and is not swept over.
    lists: ClassVar[tuple[str, ...]] = ()
    columns: ClassVar[Mapping[str, Column]]

    @abstractmethod
    def cases(self, point: Point) -> Iterable[Case]:
        """The cases of one point; none if it does not exist (a 2D scheme on a 3D scene)."""

    @abstractmethod
    def describe(self, case: Case) -> Row:
        """What all rows of a case have in common, known before it is run."""

    @abstractmethod
    def rows(self, case: Case, references: str) -> Iterator[Row]:
        """Run the case; yield what each row has beyond `describe`.

        references: folder of exact answers that other cases share, or "".
        """

    def expand(
        self, table: Mapping[str, Any], scenes: Mapping[str, Mapping[str, Any]]
    ) -> list[Case]:
        """All cases of one [[sweep]] table. Raises InputError naming the key that is wrong."""
        self._check_keys(table)
        values = {axis.name: _values(axis, table) for axis in self.axes}
        kept = {name: _list(table[name]) for name in self.lists if name in table}
        named = table.get("propagators", "lpv")
        schemes = chosen_propagators(list(named) if isinstance(named, list | tuple) else [named])
        # Scenes first, so that cases which share an exact answer stand together.
        found = [
            case
            for scene, points in self._points(table, scenes, values)
            for scheme in schemes
            for point in points
            for case in self.cases(Point(scheme, scene, {**point, **kept}))
        ]
        if not found:
            rule = "is empty: no propagator fits the dimension of any scene"
            raise bad_input("sweep", dict(table), rule)
        return found

    def _points(
        self,
        table: Mapping[str, Any],
        scenes: Mapping[str, Mapping[str, Any]],
        values: Mapping[str, list[Any]],
    ) -> Iterator[tuple[StudyScene | None, list[dict[str, Any]]]]:
        """Scenes on their grids, each with the values on all axes that belong to it."""
        points = [dict(zip(values, each)) for each in itertools.product(*values.values())]
        if not self.on_scenes:
            yield None, points
            return
        names = _list(table["scenes"])
        for resolution in values["resolution"]:
            same = [point for point in points if point["resolution"] == resolution]
            for scene in study_scenes(names, resolution, scenes):
                yield scene, same

    def _check_keys(self, table: Mapping[str, Any]) -> None:
        known = ["kind", "propagators", *(axis.name for axis in self.axes), *self.lists]
        known += ["scenes"] if self.on_scenes else []
        for key in table:
            if key not in known:
                raise bad_input("sweep", key, f"is an unknown key of kind {self.name!r}", known)
        if self.on_scenes and not table.get("scenes"):
            rule = "needs a list of scenes: names, paths, all-2d or all-3d"
            raise bad_input("scenes", table.get("scenes"), rule)


def scheme_of(parameters: Mapping[str, Any]) -> Propagator:
    """The propagator that a case's parameters name."""
    return create(parameters["propagator"], **parameters["options"])


def scheme_parameters(propagator: Propagator) -> dict[str, Any]:
    """Parameters that name a propagator, with the fingerprint of code that is not ours."""
    foreign = foreign_code(propagator.name)
    named = {"propagator": propagator.name, "options": propagator.values}
    return {**named, "foreign": foreign} if foreign else named


def scheme_row(parameters: Mapping[str, Any]) -> Row:
    """Columns that say which scheme it was; options that have their default are left out."""
    scheme = scheme_of(parameters)
    changed = {
        option.name: scheme.values[option.name]
        for option in scheme.options
        if scheme.values[option.name] != option.default
    }
    return {
        "propagator": scheme.name,
        "options": json.dumps(changed, sort_keys=True) if changed else "",
        "scheme": repr(scheme) if changed else scheme.name,
        "bands": parameters["bands"],
    }


SCHEME_COLUMNS = {
    "propagator": Column(str, "name of the scheme"),
    "options": Column(str, "its options that differ from their defaults, as JSON"),
    "scheme": Column(str, "name and options for people"),
    "bands": Column(int, "angular bands n: 2n - 1 coefficients in 2D, n² in 3D"),
}


def _values(axis: Option, table: Mapping[str, Any]) -> list[Any]:
    if axis.name not in table:
        return [axis.default]
    values = _list(table[axis.name])
    if not values:
        raise bad_input(axis.name, values, "must not be empty")
    return list(dict.fromkeys(axis.check(value) for value in values))


def _list(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else [value]
