"""What a propagator is: a name, declared options, and an answer to a scene."""

from __future__ import annotations

import dataclasses
import itertools
import warnings
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flatland.errors import SchemeWarning, bad_input
from flatland.field import Field
from flatland.harmonics import AngularBasis
from flatland.ledger import Ledger
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.stability import RADIUS_TOLERANCE
from flatland.stencil import Stencil


@dataclass(frozen=True)
class Option:
    """One declared option of a propagator: enough for a command line or an editor to offer it.

    type: bool, int, float or str. choices: accepted values, or () for any. minimum, maximum:
    inclusive bounds of a number, or None.
    """

    name: str
    type: type
    default: Any
    meaning: str
    choices: tuple[Any, ...] = ()
    minimum: float | None = None
    maximum: float | None = None

    def check(self, value: Any) -> Any:
        """The value in this option's type; text is read, so that "0.5" and "true" work.

        Raises InputError.
        """
        parsed = self._parse(value)
        if self.choices and parsed not in self.choices:
            raise bad_input(self.name, value, "is not one of the choices", self.choices)
        if self.type in (int, float):
            if not np.isfinite(parsed):
                raise bad_input(self.name, value, "must be finite")
            if self.minimum is not None and parsed < self.minimum:
                raise bad_input(self.name, value, f"must be at least {self.minimum:g}")
            if self.maximum is not None and parsed > self.maximum:
                raise bad_input(self.name, value, f"must be at most {self.maximum:g}")
        return parsed

    def _parse(self, value: Any) -> Any:
        if self.type is bool:
            words = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
            if str(value).lower() in words:
                return words[str(value).lower()]
            raise bad_input(self.name, value, "must be a truth value", ("true", "false"))
        if self.type is str:
            return str(value)
        try:
            number = self.type(value)
            exact = not isinstance(value, bool) and number == float(value)
        except (TypeError, ValueError, OverflowError):
            exact = False
        if not exact:
            kind = "a whole number" if self.type is int else "a number"
            raise bad_input(self.name, value, f"must be {kind}")
        return number


@dataclass(frozen=True, eq=False)
class Answer:
    """A field and what its scheme knows about it.

    ledger: where the flux went, if the scheme keeps books. details: numbers that say what was
    reached, such as how many directions or an estimated error.
    """

    field: Field
    ledger: Ledger | None = None
    details: dict[str, float] = dataclasses.field(default_factory=dict)


class Propagator(ABC):
    """A scheme. Everyone may call `solve`; only stencil schemes can also be stepped.

    Subclasses declare `name`, `dimensions` and `options` as class attributes.
    """

    name: ClassVar[str]
    #: One line for lists and menus.
    summary: ClassVar[str]
    dimensions: ClassVar[tuple[int, ...]] = (2,)
    options: ClassVar[tuple[Option, ...]] = ()

    def __init__(self, **values: Any) -> None:
        declared = {option.name: option for option in self.options}
        for name in values:
            if name not in declared:
                raise bad_input(f"{self.name} option", name, "is unknown", declared or ["none"])
        self.values = {
            name: option.check(values.get(name, option.default))
            for name, option in declared.items()
        }

    def __repr__(self) -> str:
        changed = {
            option.name: self.values[option.name]
            for option in self.options
            if self.values[option.name] != option.default
        }
        inner = ", ".join(f"{name}={value!r}" for name, value in changed.items())
        return f"{self.name}({inner})"

    @abstractmethod
    def solve(self, scene: Scene, bands: int, tolerance: float = 1e-8) -> Field:
        """The stationary field of a scene: intensity that leaves each cell (numerics §1)."""

    def answer(self, scene: Scene, bands: int) -> Answer:
        """The field as `solve` gives it, with books and details if the scheme has them."""
        return Answer(self.solve(scene, bands))

    def require_dimension(self, dimension: int) -> None:
        if dimension not in self.dimensions:
            rule = f"{self.name} cannot do this number of dimensions"
            raise bad_input("dimension", dimension, rule, self.dimensions)


class DirectPropagator(Propagator):
    """A scheme that answers a scene at once and keeps books; its options set the accuracy."""

    @abstractmethod
    def answer(self, scene: Scene, bands: int) -> Answer: ...

    def solve(self, scene: Scene, bands: int, tolerance: float = 1e-8) -> Field:
        """The field of `answer`. tolerance: there for the common signature."""
        return self.answer(scene, bands).field


class StencilPropagator(Propagator):
    """A scheme whose step is linear, local and the same in every cell."""

    def stencil(self, basis: AngularBasis) -> Stencil:
        """The scheme as data, for one angular basis."""
        self.require_dimension(basis.dimension)
        return self._build(basis)

    @abstractmethod
    def _build(self, basis: AngularBasis) -> Stencil: ...

    def warn_if_unstable(self, stencil: Stencil) -> None:
        """One SchemeWarning if light grows without bound, with the radius and what does not."""
        radius = stencil.spectral_radius()
        if radius <= 1 + RADIUS_TOLERANCE:
            return
        name = self.stable_alternative(stencil.basis)
        advice = f"stable: {name}" if name else "no choice of options makes it stable"
        message = (
            f"{self} with {stencil.basis.bands} bands is unstable: its spectral radius is "
            f"{radius:.4f}, so light grows without bound; {advice}"
        )
        warnings.warn(message, SchemeWarning, stacklevel=3)

    def stable_alternative(self, basis: AngularBasis) -> str | None:
        """The same scheme with as few options changed as make its radius at most 1."""
        trials = self._variations()
        for trial in sorted(trials, key=self._changes):
            if trial.stencil(basis).spectral_radius() <= 1 + RADIUS_TOLERANCE:
                return repr(trial)
        return None

    def _variations(self) -> list[StencilPropagator]:
        """Every combination of declared choices, and a propagation factor of at most 1."""
        open_options = [option for option in self.options if option.choices]
        factor = min(1.0, self.values.get("propagation_factor", 1.0))
        fixed = {**self.values}
        if "propagation_factor" in fixed:
            fixed["propagation_factor"] = factor
        names = [option.name for option in open_options]
        combinations = itertools.product(*(option.choices for option in open_options))
        return [type(self)(**{**fixed, **dict(zip(names, values))}) for values in combinations]

    def _changes(self, other: StencilPropagator) -> int:
        return sum(other.values[name] != value for name, value in self.values.items())

    def solve(self, scene: Scene, bands: int, tolerance: float = 1e-8) -> Field:
        simulation = Simulation(scene, self, bands=bands)
        simulation.solve(tolerance)
        return simulation.accumulated
