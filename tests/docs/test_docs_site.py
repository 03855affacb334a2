"""The documentation: it builds without a warning, and what it tells people to type works."""

from __future__ import annotations

import importlib
import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import gallery
import pytest
from runs import blocks, run_block
from sphinx.util.inventory import InventoryFile

import flatland
import propagators
from flatland.injectors import INJECTORS
from flatland.occluders import OCCLUDERS
from propagators.registry import BUILT_IN
from studies.figures import FIGURES

ROOT = Path(__file__).parents[2]
PAGES = sorted(page for page in (ROOT / "docs").rglob("*.md") if blocks(page))


def test_the_site_builds_without_a_warning_and_has_every_public_name(tmp_path):
    """Broken references, links to nowhere and names that are not there are warnings."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-t", "quick"]
    command += ["-d", str(tmp_path / "doctrees"), str(ROOT / "docs"), str(tmp_path / "site")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert (done.returncode, done.stderr) == (0, "")

    content = (tmp_path / "site" / "objects.inv").read_bytes()
    known = {
        name
        for kind, names in InventoryFile.loads(content, uri="").data.items()
        if kind.startswith("py:")
        for name in names
    }
    public = {f"{package.__name__}.{name}" for package in PACKAGES for name in package.__all__}
    assert public - known == set()
    schemes = {
        find.__module__ + "." + find.__qualname__ for find in map(propagators.find, BUILT_IN)
    }
    assert schemes - known == set()

    pages = [page.read_text(encoding="utf-8") for page in (tmp_path / "site").rglob("*.html")]
    fetched = re.compile(r'<(?:script|link|img)[^>]*(?:src|href)="(https?:|//)')
    assert [page for page in pages if fetched.search(page)] == [], "a page needs the network"
    assert any("<math" in page for page in pages)


PACKAGES = (flatland, propagators)
PUBLIC = [getattr(package, name) for package in PACKAGES for name in package.__all__]
PUBLIC += [propagators.find(name) for name in BUILT_IN]
PUBLIC += [*INJECTORS.values(), *OCCLUDERS.values()]


@pytest.mark.parametrize("thing", PUBLIC, ids=lambda thing: thing.__name__)
def test_every_public_name_says_what_it_is(thing):
    """Itself, and each of its public methods and properties that it declares."""
    silent = [] if inspect.getdoc(thing) and thing.__doc__ else [thing.__name__]
    for name, member in vars(thing).items() if inspect.isclass(thing) else ():
        spoken = isinstance(member, property) or inspect.isroutine(member)
        if spoken and not name.startswith("_") and not inspect.getdoc(getattr(thing, name)):
            silent.append(f"{thing.__name__}.{name}")
    assert silent == []


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_scheme_says_what_it_gets_wrong_and_has_a_page_that_shows_it(name):
    said = inspect.getdoc(propagators.find(name))
    assert "What it gets wrong" in said
    assert "numerics §" in said
    page = ROOT / "docs" / "schemes" / f"{name}.md"
    text = page.read_text(encoding="utf-8")
    for part in ("## How it works", "$$", "## What goes wrong", f"```{{scheme}} {name}\n"):
        assert part in text or name in ("dom6", "dom26")
    assert any(name in block.text for block in blocks(page))


def run_page(page, folder, slow):
    """Run the fast or the slow blocks of a page; blocks that go on need those before them."""
    place = folder
    for number, block in enumerate(blocks(page)):
        if "after" not in block.options:
            place = folder / str(number)
        if ("slow" in block.options) == slow:
            run_block(block.text, block.options, place)
            if "picture" in block.options:
                assert (place / block.options["picture"]).stat().st_size > 1000


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_of_a_page_runs(page, tmp_path):
    run_page(page, tmp_path, slow=False)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_slow_command_of_a_page_runs(page, tmp_path):
    run_page(page, tmp_path, slow=True)


def test_a_block_that_fails_is_noticed(tmp_path):
    with pytest.raises(RuntimeError, match="left with 2"):
        run_block("flatland run no-such-scene\n", {}, tmp_path)
    with pytest.raises(RuntimeError, match="is no command"):
        run_block("rm -r .\n", {}, tmp_path)


def test_plain_blocks_name_commands_that_exist():
    """Those that are shown and not run."""
    from studies.command_line import COMMANDS

    for page in (ROOT / "docs").rglob("*.md"):
        for text in re.findall(r"^```sh\n(.*?)^```", page.read_text("utf-8"), re.M | re.S):
            assert set(re.findall(r"^flatland ([a-z]+)", text, re.M)) <= set(COMMANDS)
            targets = re.findall(r"^make ([a-z0-9-]+)", text, re.M)
            makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
            assert all(f"\n{target}:" in makefile for target in targets)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in FIGURES if gallery.is_packed(name)])
def test_a_figure_whose_data_is_packed_can_be_drawn_from_it(name, tmp_path):
    """Figures that changed need `make gallery`."""
    pictures = gallery.make(name, tmp_path)
    assert pictures
    assert all(picture.stat().st_size > 1000 for picture in pictures)
    assert gallery.code_behind(name)


def test_the_packed_data_of_the_gallery_belongs_to_figures_that_are_there():
    packed = {path.name for path in gallery.PACKED.glob("*.nc.xz")}
    parts = {
        f"{name}-{part}.nc.xz"
        for name, (module, _) in FIGURES.items()
        for part in importlib.import_module(module).PARTS
    }
    assert packed <= parts
    assert set(gallery.COMPUTED) <= set(FIGURES)
