"""Which propagators a sweep means."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

from flatland.errors import bad_input
from flatland.harmonics import basis_for
from propagators import Option, Propagator, StencilPropagator, create, find, names

#: All stencil schemes with their defaults, and all with every combination of their choices.
ALL, VARIANTS = "all", "all-variants"
#: Bands at which two combinations of options are compared; enough to tell all samples apart.
_TELLING = {2: 5, 3: 3}


def chosen_propagators(entries: list[Any]) -> list[Propagator]:
    """Propagators from texts `name:key=value,…`, tables {name = …, key = …} and the words above.

    Each one once, in the order given. Raises InputError.
    """
    found = [propagator for entry in entries for propagator in _chosen(entry)]
    return list({repr(propagator): propagator for propagator in found}.values())


def scheme_text(propagator: Propagator) -> str:
    """`name:key=value,…` with the options that are not at their default."""
    changed = [
        f"{option.name}={_plain(propagator.values[option.name])}"
        for option in propagator.options
        if propagator.values[option.name] != option.default
    ]
    return propagator.name + (":" + ",".join(changed) if changed else "")


def scheme_from_text(text: str) -> Propagator:
    """The reverse. Raises InputError."""
    name, _, rest = text.partition(":")
    options = {}
    for part in rest.split(",") if rest else ():
        key, equals, value = part.partition("=")
        if not equals or not key:
            raise bad_input("propagators", text, "must be name:key=value,key=value")
        options[key.strip()] = value.strip()
    return create(name.strip(), **options)


def _chosen(entry: Any) -> Iterator[Propagator]:
    if entry == ALL:
        yield from (scheme() for scheme in _stencil_schemes())
    elif entry == VARIANTS:
        for scheme in _stencil_schemes():
            yield from _variants(scheme)
    elif isinstance(entry, str):
        yield scheme_from_text(entry)
    elif isinstance(entry, Mapping) and isinstance(entry.get("name"), str):
        options = {key: value for key, value in entry.items() if key != "name"}
        yield create(entry["name"], **options)
    else:
        rule = "must be name:key=value,… or a table {name = …, key = …}"
        raise bad_input("propagators", entry, rule, [ALL, VARIANTS, *names()])


def _stencil_schemes() -> list[type[Propagator]]:
    return [scheme for scheme in map(find, names()) if issubclass(scheme, StencilPropagator)]


def _variants(scheme: type[Propagator]) -> Iterator[Propagator]:
    """Every combination of choices that is a stencil of its own; the plainest of equals."""
    seen = set()
    for values in itertools.product(*map(_choices, scheme.options)):
        propagator = scheme(**dict(zip((option.name for option in scheme.options), values)))
        assert isinstance(propagator, StencilPropagator)
        dimension = scheme.dimensions[0]
        stencil = propagator.stencil(basis_for(dimension, _TELLING[dimension]))
        mark = stencil.transfer.tobytes(), stencil.clamp
        if mark not in seen:
            seen.add(mark)
            yield propagator


def _choices(option: Option) -> tuple[Any, ...]:
    """The default first."""
    values = option.choices or ((False, True) if option.type is bool else ())
    return (option.default, *(value for value in values if value != option.default))


def _plain(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
