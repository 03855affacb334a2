"""Kinds of cases: what a study can compute. A new kind is one module and one line here."""

from __future__ import annotations

import importlib
from functools import cache

from flatland.errors import bad_input
from studies.kinds.base import Kind

#: name: "module:class". Text, so that listing the names imports no engine.
KINDS = {
    "errors": "studies.kinds.field_errors:FieldErrors",
    "radius": "studies.kinds.radius:Radius",
    "waves": "studies.kinds.waves:Waves",
    "growth": "studies.kinds.growth:Growth",
}


@cache
def find_kind(name: str) -> Kind:
    """The kind of that name. Raises InputError for an unknown one."""
    if name not in KINDS:
        raise bad_input("kind", name, "is unknown", KINDS)
    module, _, attribute = KINDS[name].partition(":")
    kind: Kind = getattr(importlib.import_module(module), attribute)()
    return kind
