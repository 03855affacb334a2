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
