"""Every stencil scheme of the registry, so that a new one is tested by being registered."""

import itertools
from functools import cache

import pytest

import propagators
from flatland.harmonics import basis_for

#: Bands at which two combinations of options are compared; enough to tell all samples apart.
TELLING_BANDS = {2: 5, 3: 3}


def stencil_classes():
    """Classes of the registry that step."""
    classes = [propagators.find(name) for name in propagators.names()]
    return [c for c in classes if issubclass(c, propagators.StencilPropagator)]


def choices(option):
    """What an option is swept over: declared choices, both truth values, or its default."""
    if option.choices:
        return option.choices
    return (False, True) if option.type is bool else (option.default,)


def combinations(scheme):
    """Propagators of a class with all combinations of its declared choices."""
    names = [option.name for option in scheme.options]
    for values in itertools.product(*map(choices, scheme.options)):
        yield scheme(**dict(zip(names, values)))


@cache
def variants():
    """(propagator, dimension) of every combination that is a scheme of its own.

    Combinations that give the same stencil (an option that has no effect beside another) are
    tested once.
    """
    found = {}
    for scheme in stencil_classes():
        for dimension, propagator in itertools.product(scheme.dimensions, combinations(scheme)):
            stencil = propagator.stencil(basis_for(dimension, TELLING_BANDS[dimension]))
            key = (dimension, stencil.transfer.tobytes(), stencil.clamp)
            found.setdefault(key, (propagator, dimension))
    return list(found.values())


def every_scheme(condition=lambda propagator: True, dimensions=(2, 3)):
    """Parametrize a test over `propagator` and `dimension`, for those that meet a condition."""
    chosen = [
        (propagator, dimension)
        for propagator, dimension in variants()
        if condition(propagator) and dimension in dimensions
    ]
    names = [f"{propagator}-{dimension}D" for propagator, dimension in chosen]
    return pytest.mark.parametrize(("propagator", "dimension"), chosen, ids=names)


def is_linear(propagator):
    """Whether light superposes; a clamped scheme only scales."""
    return not propagator.stencil(basis_for(propagator.dimensions[0], 1)).clamp
