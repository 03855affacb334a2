"""What lights and occluders declare, read for editors: keys, kinds of value, meanings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, PlainValidator
from pydantic.fields import FieldInfo

from flatland.injectors import INJECTORS
from flatland.occluders import OCCLUDERS

#: Lists of a scene, with the registry of their kinds.
REGISTRIES: dict[str, dict[str, Any]] = {"light": INJECTORS, "occluder": OCCLUDERS}

#: Which kind of value a check stands for, by its name; others are edited as TOML text.
_KINDS = {
    "check_spacing": "number",
    "check_positive": "length",
    "check_point": "point",
    "check_space_point": "point",
    "check_origin": "vector",
    "check_position": "point",
    "check_direction": "direction",
    "check_texels": "whole",
    "check_sides": "whole",
    "check_vertices": "points",
    "check_space_vertices": "points",
    "check_quad": "points",
    "check_whole": "whole",
    "check_cell": "cell",
    "check_shape": "cell",
    "check_per_colour": "per colour",
    "check_share": "per colour",
    "check_text": "text",
    "check_file_name": "file",
    "check_mesh_name": "file",
}


@dataclass(frozen=True)
class FieldSpec:
    """One key of a table. kind: one of the above, "truth", "choice", or "toml" for any other.

    check: raises if a value breaks its rule by itself.
    """

    key: str
    kind: str
    meaning: str
    required: bool
    default: Any = None
    choices: tuple[Any, ...] = ()
    check: Callable[[Any], Any] | None = None

    @property
    def optional(self) -> bool:
        """Whether the key may be left out and then means something of its own."""
        return not self.required and self.default is None


def specs_of(model: type[BaseModel]) -> list[FieldSpec]:
    """The keys of a table but for `kind`, in the order of their declaration."""
    return [
        _spec(field.alias or name, field)
        for name, field in model.model_fields.items()
        if name != "kind"
    ]


@cache
def specs_of_kind(table: str, kind: str) -> tuple[FieldSpec, ...]:
    """The keys of a light or an occluder; none for an unknown kind."""
    model = REGISTRIES[table].get(kind)
    return tuple(specs_of(model)) if model else ()


def _spec(key: str, field: FieldInfo) -> FieldSpec:
    required = field.is_required()
    default = None if required else field.get_default(call_default_factory=True)
    check: Any = next((m.func for m in field.metadata if isinstance(m, PlainValidator)), None)
    kind, choices = _KINDS.get(getattr(check, "__name__", ""), "toml"), ()
    if key == "radius":
        kind = "length"
    annotation: Any = field.annotation
    if get_origin(annotation) is Literal:
        kind, choices = "choice", get_args(annotation)
    elif annotation is bool:
        kind = "truth"
    return FieldSpec(key, kind, field.description or "", required, default, choices, check)
