"""What lights and occluders declare, read for editors: keys, kinds of value, meanings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, PlainValidator
from pydantic.fields import FieldInfo

from flatland.injectors import INJECTORS, values
from flatland.occluders import OCCLUDERS

#: Lists of a scene, with the registry of their kinds.
REGISTRIES: dict[str, dict[str, Any]] = {"light": INJECTORS, "occluder": OCCLUDERS}

#: Which kind of value a check stands for; others are edited as TOML text.
_KINDS: dict[Callable[..., Any], str] = {
    values.check_spacing: "number",
    values.check_point: "point",
    values.check_space_point: "point",
    values.check_origin: "vector",
    values.check_position: "point",
    values.check_direction: "direction",
    values.check_positive: "length",
    values.check_quad: "points",
    values.check_space_vertices: "points",
    values.check_mesh_name: "file",
    values.check_texels: "whole",
    values.check_sides: "whole",
    values.check_vertices: "points",
    values.check_whole: "whole",
    values.check_cell: "cell",
    values.check_shape: "cell",
    values.check_per_colour: "per colour",
    values.check_share: "per colour",
    values.check_text: "text",
    values.check_file_name: "file",
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
    kind, choices = _KINDS.get(check, "toml") if check else "toml", ()
    annotation: Any = field.annotation
    if get_origin(annotation) is Literal:
        kind, choices = "choice", get_args(annotation)
    elif annotation is bool:
        kind = "truth"
    return FieldSpec(key, kind, field.description or "", required, default, choices, check)
