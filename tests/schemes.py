"""Every stencil scheme of the registry, so that a new one is tested by being registered."""

import itertools
import warnings
from functools import cache

import pytest

import propagators
from flatland.errors import SchemeWarning
from flatland.harmonics import basis_for
from flatland.scene import Scene
from flatland.simulation import Simulation

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


def every_scheme(condition=lambda propagator: True):
    """Parametrize a test over `propagator` and `dimension`, for those that meet a condition."""
    chosen = [variant for variant in variants() if condition(variant[0])]
    names = [f"{propagator}-{dimension}D" for propagator, dimension in chosen]
    return pytest.mark.parametrize(("propagator", "dimension"), chosen, ids=names)


def is_linear(propagator):
    return not propagator.values.get("clamp", False)


def quiet(propagator, scene, **arguments):
    """A simulation of a scheme that may be unstable on purpose."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SchemeWarning)
        return Simulation(scene, propagator, **arguments)


def lobe_scene(shape, cell=None, direction=None, flux=1.0):
    """One Lambertian cell in a grid, by default in its middle and along the first axis."""
    light = {
        "kind": "cell",
        "cell": [n // 2 for n in shape] if cell is None else cell,
        "direction": [1.0, *[0.0] * (len(shape) - 1)] if direction is None else direction,
        "flux": flux,
    }
    return Scene.from_dict({"grid": {"shape": shape}, "light": [light]})
