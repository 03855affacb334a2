"""The command line `flatland`: which commands there are, and how mistakes are reported."""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from typing import Any

import click

#: Bad input, or something that ran and failed.
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130

#: name: (module of the command, one line of help). Text, so that --help imports no engine.
COMMANDS = {
    "scene": ("studies.commands.scene", "List, show, check and start scene files."),
    "run": ("studies.commands.run", "Run one method on one scene."),
    "compare": ("studies.commands.compare", "Compare methods with the exact answer."),
    "study": ("studies.commands.study", "Run many cases and keep their numbers as one data set."),
    "bench": ("studies.commands.bench", "Speed on this machine, against the speed of memory."),
    "figure": ("studies.commands.figure", "Make figures, as PDF and PNG with their data."),
}


class LazyGroup(click.Group):
    """A group that imports a command when it is called, and not to list it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(COMMANDS[cmd_name][0]).command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="flatland-light", prog_name="flatland")
def flatland() -> None:
    """Simulate, measure and compare how light propagates on grids.

    Start with: flatland compare fig5-one-light -o figure.png
    """


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with 0, 1 (ran and failed) or 2 (bad input)."""
    warnings.showwarning = _show_warning
    sys.exit(_run(arguments))


def _run(arguments: list[str] | None) -> int:
    try:
        code = flatland.main(args=arguments, standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        _tell("interrupted; nothing half-written is left behind")
        return INTERRUPTED
    except BrokenPipeError:
        # The reader of our output went away (flatland … | head); that is not a failure.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:  # noqa: BLE001 - the last place before a user would see a traceback
        return _report(error)
    return code if isinstance(code, int) else 0


def _report(error: Exception) -> int:
    from flatland.errors import FlatlandError, InputError

    if isinstance(error, FlatlandError):
        _tell(f"error: {error}")
        return BAD_INPUT if isinstance(error, InputError) else FAILED
    if os.environ.get("FLATLAND_DEBUG"):
        raise error
    kind = type(error).__name__
    _tell(f"error: {kind}: {error}\nThis is a fault of flatland; FLATLAND_DEBUG=1 shows where.")
    return FAILED


def _show_warning(message: Any, category: type[Warning], *_: Any, **__: Any) -> None:
    _tell(f"warning: {message}")


def _tell(text: str) -> None:
    click.echo(f"flatland: {text}", err=True)
