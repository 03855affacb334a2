"""All propagators by name: ours, and those that other installed projects offer."""

from __future__ import annotations

import importlib
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from flatland.errors import InputError, bad_input
from propagators.base import Propagator

#: name: "module:class". Text, so that listing the names imports no scheme.
BUILT_IN = {
    "lpv": "propagators.lpv:LightPropagationVolume",
    "lpv-2009": "propagators.lpv_2009:LightPropagationVolume2009",
    "dom4": "propagators.dom:DiscreteOrdinates4",
    "dom8": "propagators.dom:DiscreteOrdinates8",
    "dom6": "propagators.dom:DiscreteOrdinates6",
    "dom26": "propagators.dom:DiscreteOrdinates26",
    "analytic": "propagators.analytic:Analytic",
    "beam": "propagators.beam:Beam",
    "sn": "propagators.sn:GridSweeps",
    "radiance-cascades": "propagators.cascades:RadianceCascades",
    "holographic-rc": "propagators.holographic:HolographicCascades",
    "light-propagation-maps": "propagators.maps:LightPropagationMaps",
    "modified-dom": "propagators.modified_dom:ModifiedDiscreteOrdinates",
}
#: Other projects register a Propagator class here, under the name that users will type.
ENTRY_POINT_GROUP = "flatland.propagators"


def names() -> list[str]:
    """Every propagator that `create` knows, ours first."""
    return [*BUILT_IN, *sorted(set(_third_party()) - set(BUILT_IN))]


def find(name: str) -> type[Propagator]:
    """The class of a propagator. Raises InputError for an unknown name or a broken plug-in."""
    if name in BUILT_IN:
        module, _, attribute = BUILT_IN[name].partition(":")
        found = getattr(importlib.import_module(module), attribute)
    elif name in _third_party():
        found = _load_third_party(name)
    else:
        raise bad_input("propagator", name, "is unknown", names())
    if not (isinstance(found, type) and issubclass(found, Propagator)):
        raise bad_input("propagator", name, f"its plug-in offers {found!r}, not a Propagator class")
    if found.__abstractmethods__:
        missing = ", ".join(sorted(found.__abstractmethods__))
        raise bad_input("propagator", name, f"its plug-in's {found.__name__} lacks {missing}")
    return found


def create(name: str, **options: Any) -> Propagator:
    """A propagator with its options; those not given take their declared defaults.

    Raises InputError for an unknown name, an unknown option or a value that breaks its rule.
    """
    return find(name)(**options)


@cache
def _third_party() -> dict[str, Any]:
    return {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}


def _load_third_party(name: str) -> Any:
    point = _third_party()[name]
    try:
        return point.load()
    except Exception as error:
        rule = f"its plug-in {point.value} cannot be loaded: {type(error).__name__}: {error}"
        raise InputError(str(bad_input("propagator", name, rule))) from error
