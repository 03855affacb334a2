"""Options that several commands share, and their reading."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

Command = Callable[..., Any]


def method_options(function: Command) -> Command:
    """How far and how precisely to run."""
    for option in (
        click.option(
            "--precision", default="float64", show_default=True, help="float64 or float32."
        ),
        click.option(
            "--device", default="cpu", show_default=True, help="cpu, or cuda (needs CuPy)."
        ),
        click.option("--lights-block", is_flag=True, help="Area lights stop light like walls."),
        click.option("--no-bounces", is_flag=True, help="Walls send nothing back."),
        click.option(
            "--strength", default=1.0, show_default=True, help="Factor on fuzzy blocking."
        ),
        click.option(
            "--blocking", default="exact", show_default=True, help="exact, fuzzy or none."
        ),
        click.option(
            "--converge",
            type=float,
            metavar="TOL",
            help="Solve for the converged field, to this relative residual.",
        ),
        click.option("--iterations", type=int, metavar="N", help="Steps; 2 x the longest side."),
    ):
        function = option(function)
    return function


def level_options(function: Command) -> Command:
    """Levels of an octree, how they are filled and how they are read."""
    for option in (
        click.option(
            "--blend",
            type=float,
            metavar="CELLS",
            help="Fade levels into each other over so many cells of the coarser one.",
        ),
        click.option(
            "--patience",
            default=1.0,
            show_default=True,
            help="Read a level after so many times the steps that its first light took.",
        ),
        click.option("--index", default="finest", show_default=True, help="finest or symmetric."),
        click.option(
            "--falloff", default="cells", show_default=True, help="Light fades per cells or metres."
        ),
        click.option(
            "--level-factors", metavar="LIST", help="Factor of each level instead, as in 1,2.5,7."
        ),
        click.option(
            "--normalization",
            default="flux",
            show_default=True,
            help="Levels get flux (2^i times the mean) or the mean of level 0.",
        ),
        click.option("--levels", default=1, show_default=True, help="Octree levels."),
    ):
        function = option(function)
    return function


def level_values(values: dict[str, Any]) -> dict[str, Any]:
    """Take what `level_options` gave out of `values`, as arguments of Method. Raises InputError."""
    names = ("levels", "normalization", "level_factors", "falloff", "index", "patience", "blend")
    chosen = {name: values.pop(name) for name in names}
    if chosen["level_factors"] is not None:
        chosen["level_factors"] = numbers(chosen["level_factors"], "--level-factors")
    return chosen


def read_view(text: str, levels: int) -> int | None:
    """`merged` as None, `level:i` as the level's number. Raises InputError."""
    from flatland.errors import bad_input

    choices = ["merged", *(f"level:{number}" for number in range(levels))]
    if text not in choices:
        raise bad_input("--view", text, "is unknown", choices)
    return None if text == "merged" else choices.index(text) - 1


def numbers(text: str, argument: str) -> tuple[float, ...]:
    """A comma-separated list of numbers. Raises InputError."""
    from flatland.errors import bad_input

    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise bad_input(argument, text, "must be numbers, as in 1,2.5,7") from None


def scheme_options(values: tuple[str, ...]) -> dict[str, str]:
    """`key=value` texts as a dictionary. Raises InputError."""
    from flatland.errors import bad_input

    pairs = {}
    for text in values:
        key, equals, value = text.partition("=")
        if not equals or not key:
            raise bad_input("--option", text, "must be key=value, as in flux=central")
        pairs[key.strip()] = value.strip()
    return pairs


def whole_numbers(text: str, argument: str) -> list[int]:
    """A comma-separated list of whole numbers, at least 1 each. Raises InputError."""
    from flatland.errors import bad_input

    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdigit() and int(part) >= 1 for part in parts):
        raise bad_input(argument, text, "must be whole numbers, as in 2,4,8")
    return [int(part) for part in parts]


def check_stopping(iterations: int | None, converge: float | None) -> None:
    """Only one of both may be given. Raises InputError."""
    from flatland.errors import bad_input

    if iterations is not None and converge is not None:
        raise bad_input("--iterations", iterations, "cannot be given together with --converge")
    if iterations is not None and iterations < 0:
        raise bad_input("--iterations", iterations, "must be at least 0")
    if converge is not None and not 0 < converge < 1:
        raise bad_input("--converge", converge, "must lie between 0 and 1")


def plain_numbers(values: dict[str, float]) -> dict[str, float | None]:
    """Numbers for JSON, which has no NaN."""
    return {name: None if value != value else value for name, value in values.items()}
