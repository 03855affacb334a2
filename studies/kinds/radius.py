"""How fast the fastest wave of a scheme grows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, ClassVar

from flatland.harmonics import basis_for
from flatland.stability import RADIUS_TOLERANCE
from flatland.stencil import Stencil
from propagators import Option, StencilPropagator
from studies.kinds.base import (
    SCHEME_COLUMNS,
    Column,
    Kind,
    Point,
    Row,
    scheme_of,
    scheme_parameters,
    scheme_row,
)
from studies.sweeps.case import Case

SYMBOL_AXES = (
    Option("bands", int, 2, "angular bands", minimum=1),
    Option("dimension", int, 2, "of the grid", (2, 3)),
)


class OnSymbols(Kind):
    """Kinds that look at a stencil alone, without a scene."""

    on_scenes = False
    axes = SYMBOL_AXES

    def cases(self, point: Point) -> Iterable[Case]:
        fits = point.values["dimension"] in point.propagator.dimensions
        if fits and isinstance(point.propagator, StencilPropagator):
            parameters = {**scheme_parameters(point.propagator), **point.values}
            yield Case(self.name, parameters)

    def describe(self, case: Case) -> Row:
        return {"dimension": case.parameters["dimension"], **scheme_row(case.parameters)}


class Radius(OnSymbols):
    """One row: the spectral radius of the symbol over all wave vectors (numerics §3)."""

    name = "radius"
    summary = "spectral radius of a scheme: the growth of its fastest wave a step"
    columns: ClassVar = {
        "dimension": Column(int, "of the grid"),
        **SCHEME_COLUMNS,
        "radius": Column(float, "spectral radius ρ; of a clamped scheme that of its linear twin"),
        "stable": Column(bool, "whether ρ is at most 1, up to rounding"),
        "clamped": Column(bool, "whether the step is clamped, so that ρ is not the whole story"),
        "command": Column(str, "what computes the row again"),
    }

    def rows(self, case: Case, references: str) -> Iterator[Row]:
        stencil = stencil_of(case.parameters)
        radius = stencil.spectral_radius()
        yield {
            "radius": radius,
            "stable": radius <= 1 + RADIUS_TOLERANCE,
            "clamped": stencil.clamp,
            "command": python_command(case.parameters, "print(stencil.spectral_radius())"),
        }


def stencil_of(parameters: Any) -> Stencil:
    """The stencil that a case's parameters name."""
    scheme = scheme_of(parameters)
    assert isinstance(scheme, StencilPropagator)
    return scheme.stencil(basis_for(parameters["dimension"], parameters["bands"]))


def python_command(parameters: Any, ending: str) -> str:
    """A Python command that makes a case's `stencil` and does something with it."""
    scheme = scheme_of(parameters)
    options = "".join(
        f", {option.name}={scheme.values[option.name]!r}"
        for option in scheme.options
        if scheme.values[option.name] != option.default
    )
    basis = f"basis_for({parameters['dimension']}, {parameters['bands']})"
    made = f"stencil = create({scheme.name!r}{options}).stencil({basis})"
    imports = "from flatland.harmonics import basis_for; from propagators import create"
    return f'python -c "{imports}; {made}; {ending}"'
