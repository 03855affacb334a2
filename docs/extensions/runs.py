"""The directive `run`: commands that the page shows, run when the page is built.

    ```{run}
    :picture: shelf.png
    :alt: what the picture shows
    flatland compare shelf --bands 4 -o shelf.png
    ```

shows the command, what it prints and its picture. Lines begin with `flatland` or `python FILE`; a
block with `:python:` is a program itself. Each block runs in a folder of its own, beside copies of
docs/examples, and is kept until it or the code changes. A block that fails is a warning of the
build. Options: `picture` (a file that it writes), `alt`, `lines` (how many lines of what it prints
are shown; all by default), `after` (it finds the files of the block before), `status` (what a
command leaves with; 0 by default), `slow` (the fast tests leave it out).
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import re
import runpy
import shlex
import shutil
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

_LOG = logging.getLogger(__name__)
#: Files that blocks may name; each runs beside copies of them.
EXAMPLES = Path(__file__).parents[1] / "examples"
_BLOCK = re.compile(r"^```\{run\}\n((?::[^\n]*\n)*)\n?(.*?)^```", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """One `run` block of a page: its options and its text."""

    options: dict[str, str]
    text: str


def blocks(page: Path) -> list[Block]:
    """The `run` blocks of a page, in their order."""
    found = []
    for options, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        pairs = (line[1:].partition(":") for line in options.splitlines())
        found.append(Block({name: value.strip() for name, _, value in pairs}, text))
    return found


def run_block(text: str, options: Mapping[str, object], folder: Path) -> str:
    """What the commands or the program print in a folder. Raises RuntimeError if one fails."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in EXAMPLES.iterdir():
        if path.is_file():
            shutil.copy(path, folder)
    printed = io.StringIO()
    with _inside(folder), contextlib.redirect_stdout(printed):
        if "python" in options:
            exec(compile(text, "page", "exec"), {"__name__": "__main__"})
        else:
            for command in commands(text):
                _run_command(command, int(str(options.get("status", 0))))
    return printed.getvalue()


def commands(text: str) -> list[list[str]]:
    """The arguments of each command of a block; a backslash carries on to the next line."""
    lines = text.replace("\\\n", " ").splitlines()
    return [shlex.split(line, comments=True) for line in lines if line.strip()]


def _run_command(words: list[str], wanted: int) -> None:
    from studies.command_line import _run

    if words[:1] == ["python"]:
        runpy.run_path(words[1], run_name="__main__")
        return
    if words[:1] != ["flatland"]:
        raise RuntimeError(f"{shlex.join(words)}: is no command of flatland")
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        code = _run(words[1:])
    if code != wanted:
        raise RuntimeError(f"{shlex.join(words)}: left with {code}: {said.getvalue()}")


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """The folder as the current one, whose modules can be imported."""
    before = Path.cwd()
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        os.chdir(before)


class RunDirective(SphinxDirective):
    """`run`, as described above."""

    has_content = True
    option_spec = {  # noqa: RUF012 - docutils' way of declaring options
        "picture": directives.path,
        "alt": directives.unchanged,
        "lines": directives.nonnegative_int,
        "python": directives.flag,
        "after": directives.flag,
        "status": directives.nonnegative_int,
        "slow": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        text = "\n".join(self.content) + "\n"
        python = "python" in self.options
        shown = nodes.literal_block(text, text, language="python" if python else "sh")
        if self.env.app.tags.has("quick"):
            return [shown]
        try:
            folder = self._done(text, python)
        except Exception as error:  # noqa: BLE001 - whatever it is, the page is wrong
            _LOG.warning("run: %s", error, location=self.get_location())
            return [shown]
        return [shown, *self._printed(folder), *self._picture(folder)]

    def _done(self, text: str, python: bool) -> Path:
        """The folder in which the block was run, now or by an earlier build."""
        from studies.sweeps.code import code_version

        before = self.env.temp_data.get("run_folder") if "after" in self.options else None
        origin = f"{code_version()} {before} {python} {text}"
        key = hashlib.sha256(origin.encode()).hexdigest()[:16]
        folder = Path(self.env.srcdir) / "generated" / "runs" / key
        if not (folder / "printed.txt").exists():
            if before is not None:
                shutil.copytree(before, folder, ignore=shutil.ignore_patterns("printed.txt"))
            printed = run_block(text, self.options, folder)
            (folder / "printed.txt").write_text(printed, encoding="utf-8")
        self.env.temp_data["run_folder"] = folder
        return folder

    def _printed(self, folder: Path) -> list[nodes.Node]:
        lines = (folder / "printed.txt").read_text(encoding="utf-8").rstrip().splitlines()
        lines = [line for line in lines if not line.startswith("wrote ")]
        count = self.options.get("lines", len(lines))
        text = "\n".join(lines[:count]).rstrip()
        return (
            [nodes.literal_block(text, text, language="text", classes=["printed"])] if text else []
        )

    def _picture(self, folder: Path) -> list[nodes.Node]:
        if "picture" not in self.options:
            return []
        path = folder / self.options["picture"]
        if not path.exists():
            _LOG.warning("run: wrote no %s", path.name, location=self.get_location())
            return []
        place = "/" + path.relative_to(self.env.srcdir).as_posix()
        return [nodes.image(uri=place, alt=self.options.get("alt", ""), classes=["run-picture"])]


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the directive."""
    app.add_directive("run", RunDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
