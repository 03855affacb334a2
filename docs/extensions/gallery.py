"""The directives `figures`, every figure of the registry, and `drawn NAME PART`, one picture.

Both are drawn when the page is built.

Figures that rest on studies take minutes to compute. Their data, exactly as `flatland figure`
stores it, lies packed in docs/gallery, and only the drawing is done here. Those in COMPUTED are
computed.

    python docs/extensions/gallery.py out

packs anew what `flatland figure ... -o out` has stored (`make gallery` does both).
"""

from __future__ import annotations

import importlib
import inspect
import lzma
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

_LOG = logging.getLogger(__name__)
PACKED = Path(__file__).parents[1] / "gallery"
#: Figures that need no study and take seconds.
COMPUTED = (
    "clpv-fig2",
    "clpv-fig5",
    "clpv-fig11",
    "clpv-fig12",
    "octree-fig2",
    "octree-fig3",
    "octree-fig16",
)


class DrawnDirective(SphinxDirective):
    """`drawn NAME PART`; a figure of one picture has no parts."""

    required_arguments = 1
    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        name, stem = self.arguments[0], "-".join(self.arguments)
        if self.env.app.tags.has("quick"):
            return []
        places = [place for place in _pictures(self, name) if Path(place).stem == stem]
        if not places:
            _LOG.warning("drawn: no picture %s", stem, location=self.get_location())
        looks = {"alt": stem, "classes": ["gallery-picture"]}
        return [nodes.image(uri=place, **looks) for place in places]


class FiguresDirective(SphinxDirective):
    """`figures`: cards of all figures, then each of them with what it shows."""

    def run(self) -> list[nodes.Node]:
        from studies.figures import FIGURES

        made = {name: _pictures(self, name) for name in FIGURES}
        cards = nodes.container(classes=["cards"])
        cards += [_card(name, made[name][0]) for name in FIGURES if made[name]]
        return [
            cards,
            *(self._section(name, text, made[name]) for name, (_, text) in FIGURES.items()),
        ]

    def _section(self, name: str, text: str, pictures: list[str]) -> nodes.section:
        from studies.figures import FIGURES

        section = nodes.section(ids=[f"figure-{name}"], names=[name])
        section += nodes.title(name, name)
        module = importlib.import_module(FIGURES[name][0])
        said = inspect.cleandoc(module.__doc__ or "").partition("\n\n")[2]
        lines = [f"{text[0].upper()}{text[1:]}.", "", said, ""]
        if not pictures:
            lines += ["Not drawn in this build: its numbers take a study of some minutes.", ""]
        if pictures and (code := code_behind(name)):
            lines += [f"Drawn from stored data, computed by version {code}.", ""]
        section += self.parse_text_to_nodes("\n".join(lines))
        looks = {"alt": text, "classes": ["gallery-picture"]}
        section += [nodes.image(uri=place, **looks) for place in pictures]
        lines = ["```sh", f"flatland figure {name}", "```", "", _downloads(pictures)]
        section += self.parse_text_to_nodes("\n".join(lines))
        return section


def _pictures(directive: SphinxDirective, name: str) -> list[str]:
    """Places of the pictures of a figure below the source folder."""
    if directive.env.app.tags.has("quick"):
        return []
    try:
        paths = make(name, Path(directive.env.srcdir) / "generated" / "figures")
    except Exception as error:  # noqa: BLE001 - whatever it is, the page is wrong
        _LOG.warning("figure %s: %s", name, error, location=directive.get_location())
        return []
    return ["/" + path.relative_to(directive.env.srcdir).as_posix() for path in paths]


def _card(name: str, picture: str) -> nodes.container:
    link = nodes.reference("", "", internal=True, refuri=f"#figure-{name}")
    link += nodes.image(uri=picture, alt="")
    link += nodes.inline(name, name)
    return nodes.container("", nodes.paragraph("", "", link), classes=["card"])


def _downloads(pictures: list[str]) -> str:
    """Links to the same pictures as PDF."""
    links = [
        f"{{download}}`{Path(place).stem}.pdf <{place.removesuffix('.png')}.pdf>`"
        for place in pictures
    ]
    return f"For print: {', '.join(links)}." if links else ""


def make(name: str, folder: Path) -> list[Path]:
    """PNG files of a figure in a folder of its own for this code; [] if its data is not at hand."""
    from flatland.results import write_atomically
    from studies.figures import FIGURES
    from studies.sweeps.code import code_version

    stamp = folder / f"{name}.made"
    module = importlib.import_module(FIGURES[name][0])
    version = f"{code_version()} {_bytes_of(module)}"
    if stamp.exists() and stamp.read_text(encoding="utf-8").splitlines()[0] == version:
        return [folder / line for line in stamp.read_text(encoding="utf-8").splitlines()[1:]]
    folder.mkdir(parents=True, exist_ok=True)
    if is_packed(name):
        for path in packed_data(name):
            content = lzma.decompress(path.read_bytes())
            write_atomically(
                folder / path.stem, lambda place, data=content: place.write_bytes(data)
            )
    elif name not in COMPUTED:
        return []
    paths = _drawn(name, folder, from_data=is_packed(name))
    stamp.write_text("\n".join([version, *(path.name for path in paths)]), encoding="utf-8")
    return paths


def packed_data(name: str) -> list[Path]:
    """Where the packed data of a figure's parts lies, there or not."""
    from studies.figures import FIGURES

    module = importlib.import_module(FIGURES[name][0])
    return [PACKED / f"{name}-{part}.nc.xz" for part in module.PARTS]


def is_packed(name: str) -> bool:
    """Whether a figure can be drawn without computing it."""
    return all(path.exists() for path in packed_data(name))


def code_behind(name: str) -> str:
    """The version of the code that computed a figure's packed data; "" if none is packed."""
    import io

    import xarray as xr

    for path in filter(Path.exists, packed_data(name)):
        content = io.BytesIO(lzma.decompress(path.read_bytes()))
        with xr.open_dataset(content, engine="h5netcdf") as data:
            if "code" in data.attrs:
                return str(data.attrs["code"])
    return ""


def _drawn(name: str, folder: Path, from_data: bool) -> list[Path]:
    import contextlib
    import io

    from studies.command_line import _run

    data = ["--data"] if from_data else []
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        code = _run(["figure", name, "-o", str(folder), *data])
    if code != 0:
        raise RuntimeError(said.getvalue())
    lines = [line.removeprefix("wrote ") for line in said.getvalue().splitlines()]
    return [Path(line) for line in lines if line.endswith(".png")]


def _bytes_of(module: Any) -> str:
    import hashlib

    source = Path(str(inspect.getsourcefile(module)))
    return hashlib.sha256(source.read_bytes()).hexdigest()[:12]


def pack(folder: Path) -> list[Path]:
    """Pack what is stored of figures that are not computed here into docs/gallery."""
    from studies.figures import FIGURES

    written = []
    for name, (module, _) in FIGURES.items():
        if name in COMPUTED:
            continue
        for part in importlib.import_module(module).PARTS:
            target = PACKED / f"{name}-{part}.nc.xz"
            stored = folder / f"{name}-{part}.nc"
            if stored.exists():
                target.write_bytes(lzma.compress(stored.read_bytes(), preset=9))
                written.append(target)
    return written


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the directives."""
    app.add_directive("drawn", DrawnDirective)
    app.add_directive("figures", FiguresDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    for path in pack(Path(sys.argv[1])):
        print(path)
