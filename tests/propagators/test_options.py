"""Declared options: what is accepted, what is read from text, and what is refused."""

import math

import numpy as np
import pytest
from schemes import stencil_classes

import propagators
from flatland.errors import InputError
from propagators.base import Option

SHARE = Option("share", float, 0.5, "a share", minimum=0.0, maximum=1.0)
COUNT = Option("count", int, 3, "a count", minimum=1)
CLAMP = Option("clamp", bool, False, "a truth value")
FLUX = Option("flux", str, "transfer", "a choice", ("transfer", "central"))
ORDER = Option("order", int, 2, "a choice of numbers", (2, 4))

every_propagator = pytest.mark.parametrize("name", propagators.names())


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        (SHARE, 0.25, 0.25),
        (SHARE, "0.5", 0.5),
        (SHARE, " 1e-3 ", 1e-3),
        (SHARE, 1, 1.0),
        (SHARE, np.float32(0.5), 0.5),
        (COUNT, 7, 7),
        (COUNT, "12", 12),
        (COUNT, 5.0, 5),
        (COUNT, np.int64(4), 4),
        (CLAMP, True, True),
        (CLAMP, "true", True),
        (CLAMP, "Yes", True),
        (CLAMP, "1", True),
        (CLAMP, 1, True),
        (CLAMP, "false", False),
        (CLAMP, "no", False),
        (CLAMP, 0, False),
        (FLUX, "central", "central"),
        (ORDER, "4", 4),
    ],
)
def test_values_and_their_text_are_read(option, value, expected):
    found = option.check(value)
    assert found == expected
    assert type(found) is option.type


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_bounds_belong_to_the_range(value):
    assert SHARE.check(value) == value


@pytest.mark.parametrize(
    ("option", "value", "rule"),
    [
        (SHARE, -0.001, "must be at least 0"),
        (SHARE, 1.001, "must be at most 1"),
        (SHARE, "half", "must be a number"),
        (SHARE, "", "must be a number"),
        (SHARE, None, "must be a number"),
        (SHARE, True, "must be a number"),
        (SHARE, [0.5], "must be a number"),
        (SHARE, math.nan, "must be a number"),
        (SHARE, math.inf, "must be finite"),
        (COUNT, 0, "must be at least 1"),
        (COUNT, 2.5, "must be a whole number"),
        (COUNT, "2.5", "must be a whole number"),
        (COUNT, math.nan, "must be a whole number"),
        (COUNT, math.inf, "must be a whole number"),
        (CLAMP, "perhaps", "must be a truth value; accepted: true, false"),
        (CLAMP, 2, "must be a truth value; accepted: true, false"),
        (CLAMP, None, "must be a truth value; accepted: true, false"),
        (FLUX, "centre", "is not one of the choices; accepted: transfer, central"),
        (FLUX, 3, "is not one of the choices; accepted: transfer, central"),
        (ORDER, 3, "is not one of the choices; accepted: 2, 4"),
    ],
)
def test_errors_name_option_value_and_rule(option, value, rule):
    with pytest.raises(InputError) as caught:
        option.check(value)
    assert str(caught.value) == f"{option.name} = {value!r}: {rule}"


def test_a_number_too_large_for_a_float_is_no_number():
    with pytest.raises(InputError, match="must be a whole number"):
        COUNT.check(10**400)


@every_propagator
def test_defaults_obey_their_own_rules(name):
    for option in propagators.find(name).options:
        assert option.check(option.default) == option.default
        assert all(option.check(choice) == choice for choice in option.choices)


@every_propagator
def test_every_option_says_what_it_means(name):
    options = propagators.find(name).options
    assert all(option.meaning for option in options)
    assert len({option.name for option in options}) == len(options)


@every_propagator
def test_without_options_the_defaults_hold(name):
    propagator = propagators.create(name)
    assert propagator.values == {option.name: option.default for option in propagator.options}
    assert repr(propagator) == f"{name}()"


@pytest.mark.parametrize("name", [scheme.name for scheme in stencil_classes()])
def test_repr_shows_what_was_changed(name):
    propagator = propagators.create(name, propagation_factor="0.5")
    assert repr(propagator) == f"{name}(propagation_factor=0.5)"


def test_options_are_read_from_text():
    written = propagators.create("lpv", flux="central", clamp="true", propagation_factor="0.5")
    meant = propagators.create("lpv", flux="central", clamp=True, propagation_factor=0.5)
    assert written.values == meant.values


def test_unknown_option_lists_the_options():
    with pytest.raises(InputError) as caught:
        propagators.create("dom4", fluxx="central")
    message = "dom4 option = 'fluxx': is unknown; accepted: flux, emission, propagation_factor"
    assert str(caught.value) == message


def test_unknown_option_of_a_propagator_that_is_no_stencil():
    with pytest.raises(InputError, match=r"'flux': is unknown; accepted: element, bounces"):
        propagators.create("analytic", flux="central")


@pytest.mark.parametrize("factor", [-0.1, 10.1, "nan", "inf", "big", True])
def test_propagation_factor_is_bounded(factor):
    with pytest.raises(InputError, match=r"^propagation_factor = "):
        propagators.create("lpv", propagation_factor=factor)
