"""The project's errors, and the one voice in which bad input is refused."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


class FlatlandError(Exception):
    """Base of every error this project raises on purpose."""


class InputError(FlatlandError, ValueError):
    """An argument, option, scene or file breaks a rule; the message says which and how."""


class InstabilityError(FlatlandError, ArithmeticError):
    """A run grew towards overflow, or a stationary answer was asked of a scheme without one."""


class ConvergenceError(FlatlandError, ArithmeticError):
    """A solver stopped before it reached its tolerance."""


class ResultFileError(FlatlandError, OSError):
    """A result could not be written or read."""


class SchemeWarning(UserWarning):
    """The chosen method will give an answer that its user should not trust unread."""


def bad_input(
    argument: str, value: Any, rule: str, choices: Iterable[object] | None = None
) -> InputError:
    """The error for one broken rule: names the argument, the value, the rule and the choices."""
    shown = repr(value)
    if len(shown) > 120:
        shown = shown[:117] + "..."
    message = f"{argument} = {shown}: {rule}"
    if choices is not None:
        message += "; accepted: " + ", ".join(map(str, choices))
    return InputError(message)
