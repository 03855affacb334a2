"""Values that scene files may hold: each type checks itself and says which rule was broken."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import PlainValidator
from pydantic_core import PydanticCustomError

#: Largest size of a number: products of several stay far from overflow.
LARGEST = 1e100
#: Most cells along an axis: indices stay within 32 bits.
MOST_CELLS = 2**31 - 1
#: Most texels of a shadow map, and most sides of a circle.
MOST_TEXELS, MOST_SIDES = 2**20, 2**16
#: Endings of mesh files, in either case.
MESH_ENDINGS = (".stl", ".obj", ".ply", ".off")
#: Most texels along a side of a shadow map in 3D.
MOST_TEXELS_3D = 1024
#: Marks "the value that was given", where a broken rule brings no value of its own.
AS_GIVEN = object()


@dataclass(frozen=True)
class Broken:
    """A rule that a value breaks, and what would be accepted instead.

    key: the key inside the table, where the check sees a whole table; None otherwise.
    """

    rule: str
    choices: tuple[object, ...] | None = None
    key: str | None = None
    value: Any = AS_GIVEN


def refuse(*broken: Broken) -> PydanticCustomError:
    """The error that carries broken rules through validation."""
    text = "; ".join(f"{b.key}: {b.rule}" if b.key else b.rule for b in broken)
    return PydanticCustomError("broken_rules", "{text}", {"text": text, "broken": broken})


def check_number(
    value: Any, minimum: float = -LARGEST, maximum: float = LARGEST, what: str = "a number"
) -> float:
    """`value` as a float; text and truth values are no numbers."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refuse(Broken(f"must be {what}"))
    if not -LARGEST <= value <= LARGEST:  # NaN fails this too
        raise refuse(Broken(f"must be {what}, finite and at most {LARGEST:g} in size"))
    if not minimum <= value <= maximum:
        bound = f"at least {minimum:g}" if value < minimum else f"at most {maximum:g}"
        raise refuse(Broken(f"must be {bound}"))
    return float(value)


def check_whole(value: Any, minimum: int = 0, maximum: int = MOST_CELLS) -> int:
    """`value` as a whole number from `minimum` to `maximum`."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise refuse(Broken("must be a whole number"))
    if not minimum <= value <= maximum:
        raise refuse(Broken(f"must be a whole number from {minimum} to {maximum}"))
    return int(value)


def check_spacing(value: Any) -> float:
    number = check_number(value)
    if number < 1 / LARGEST:
        rule = "must be greater than 0" if number <= 0 else f"must be at least {1 / LARGEST:g}"
        raise refuse(Broken(rule))
    return number


def check_list(value: Any, sizes: Iterable[int], item: Callable[[Any], Any], what: str) -> Any:
    """`value` as a tuple of one of the lengths, each entry checked by `item`."""
    if not isinstance(value, list | tuple) or len(value) not in sizes:
        raise refuse(Broken(f"must be {what}"))
    return tuple(item(entry) for entry in value)


def check_point(value: Any) -> tuple[float, float]:
    return check_list(value, (2,), check_number, "2 numbers, [x, y]")


def check_space_point(value: Any) -> tuple[float, float, float]:
    return check_list(value, (3,), check_number, "3 numbers, [x, y, z]")


def check_space_vertices(value: Any, count: int | None = None) -> tuple[Any, ...]:
    """At least 3 points in space, or exactly `count`."""
    what = f"a list of {count or 'at least 3'} points [x, y, z]"
    if not isinstance(value, list | tuple) or len(value) < 3 or count not in (None, len(value)):
        raise refuse(Broken(f"must be {what}"))
    return tuple(check_list(point, (3,), check_number, what) for point in value)


def check_quad(value: Any) -> tuple[Any, ...]:
    return check_space_vertices(value, 4)


def check_position(value: Any) -> tuple[float, ...]:
    return check_list(value, (2, 3), check_number, "2 or 3 numbers, one per axis")


def check_origin(value: Any) -> tuple[float, ...]:
    return () if value == () else check_position(value)


def check_direction(value: Any) -> tuple[float, ...]:
    direction = check_position(value)
    if not any(direction):
        raise refuse(Broken("must not be zero in all components"))
    return direction


def check_positive(value: Any) -> float:
    number = check_number(value)
    if number < 1 / LARGEST:
        raise refuse(Broken(f"must be greater than 0, at least {1 / LARGEST:g}"))
    return number


def check_texels(value: Any) -> int:
    return check_whole(value, 1, MOST_TEXELS)


def check_sides(value: Any) -> int:
    return check_whole(value, 3, MOST_SIDES)


def check_vertices(value: Any) -> tuple[tuple[float, float], ...]:
    what = "a list of at least 3 points [x, y]"
    if not isinstance(value, list | tuple) or len(value) < 3:
        raise refuse(Broken(f"must be {what}"))
    return tuple(check_list(point, (2,), check_number, what) for point in value)


def check_cell(value: Any) -> tuple[int, ...]:
    return check_list(value, (2, 3), check_whole, "2 or 3 whole numbers, one per axis")


def check_shape(value: Any) -> tuple[int, ...]:
    def count(entry: Any) -> int:
        return check_whole(entry, minimum=1)

    return check_list(value, (2, 3), count, "2 or 3 numbers of cells, one per axis")


def check_per_colour(value: Any, maximum: float = LARGEST) -> float | tuple[float, ...]:
    """A number from 0 to `maximum`, or a non-empty list of them, one per colour."""
    what = "a number, or a list with one number per colour"
    if not isinstance(value, list | tuple):
        return check_number(value, 0.0, maximum, what)
    if not value:
        raise refuse(Broken(f"must be {what}"))
    return tuple(check_number(entry, 0.0, maximum, what) for entry in value)


def check_share(value: Any) -> float | tuple[float, ...]:
    return check_per_colour(value, maximum=1.0)


def check_text(value: Any) -> str:
    if not isinstance(value, str):
        raise refuse(Broken("must be text"))
    try:
        value.encode()
    except UnicodeEncodeError:
        raise refuse(Broken("must be text that can be stored as UTF-8")) from None
    return value


def check_file_name(
    value: Any, what: str = "a data file", endings: tuple[str, ...] = (".npy", ".npz")
) -> str:
    name = check_text(value)
    if not name or "\0" in name or not name.endswith(endings):
        raise refuse(Broken(f"must be the name of {what}", endings))
    return name


def check_mesh_name(value: Any) -> str:
    check_file_name(str(value).lower(), "a mesh file", MESH_ENDINGS)
    return check_text(value)


Spacing = Annotated[float, PlainValidator(check_spacing)]
Point = Annotated[tuple[float, float], PlainValidator(check_point)]
SpacePoint = Annotated[tuple[float, float, float], PlainValidator(check_space_point)]
OptionalPoint = Annotated[tuple[float, float] | None, PlainValidator(check_point)]
SpaceVertices = Annotated[
    tuple[tuple[float, float, float], ...], PlainValidator(check_space_vertices)
]
OptionalSpaceVertices = Annotated[
    tuple[tuple[float, float, float], ...] | None, PlainValidator(check_space_vertices)
]
Quad = Annotated[tuple[tuple[float, float, float], ...], PlainValidator(check_quad)]
Origin = Annotated[tuple[float, ...], PlainValidator(check_origin)]
Direction = Annotated[tuple[float, ...] | None, PlainValidator(check_direction)]
Position = Annotated[tuple[float, ...], PlainValidator(check_position)]
Heading = Annotated[tuple[float, ...], PlainValidator(check_direction)]
Radius = Annotated[float, PlainValidator(check_positive)]
Factor = Annotated[float, PlainValidator(check_positive)]
Texels = Annotated[int, PlainValidator(check_texels)]
Sides = Annotated[int, PlainValidator(check_sides)]
Vertices = Annotated[tuple[tuple[float, float], ...], PlainValidator(check_vertices)]
Index = Annotated[int, PlainValidator(check_whole)]
OptionalIndex = Annotated[int | None, PlainValidator(check_whole)]
Cell = Annotated[tuple[int, ...], PlainValidator(check_cell)]
Shape = Annotated[tuple[int, ...], PlainValidator(check_shape)]
PerColour = Annotated[float | tuple[float, ...], PlainValidator(check_per_colour)]
OptionalPerColour = Annotated[float | tuple[float, ...] | None, PlainValidator(check_per_colour)]
Share = Annotated[float | tuple[float, ...], PlainValidator(check_share)]
Text = Annotated[str, PlainValidator(check_text)]
FileName = Annotated[str, PlainValidator(check_file_name)]
MeshName = Annotated[str, PlainValidator(check_mesh_name)]
