"""How the documentation is built: `make docs`, or `sphinx-build docs out/docs`. Needs no network.

With `-t quick` nothing is computed: commands are shown without what they print, and the gallery
without pictures. References, links and the interface are checked all the same.
"""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))
sys.path.insert(0, str(HERE.parent))

project = "flatland"
author = "the flatland authors"
project_copyright = author

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "docstrings",
    "gallery",
    "mathml",
    "runs",
    "scheme_pages",
]
exclude_patterns = ["images/*", "generated/*"]
templates_path: list[str] = []

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]

nitpicky = True
#: Types of other projects, and names that stand for arrays; there is no network to look them up.
nitpick_ignore_regex = [
    ("py:.*", r"(np|numpy|os|pathlib|xarray|xr|collections|pydantic|abc|typing|datetime)\..*"),
    (
        "py:.*",
        r"(Array|ArrayLike|NDArray|Values|Flux|Mask|Any|Path|Self|Literal)",
    ),
    ("py:.*", r"(Callable|Iterable|Mapping|Sequence|ClassVar|ABC|UserWarning|TypeAliasForwardRef)"),
]
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_type_aliases = {
    name: name for name in ("Array", "ArrayLike", "Flux", "Mask", "NDArray", "Values")
}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 80

html_theme = "furo"
html_title = "flatland"
html_static_path = ["static"]
html_css_files = ["flatland.css"]
html_copy_source = False
html_show_sphinx = False
html_math_renderer = "mathml"
html_theme_options = {"navigation_with_keys": True}
pygments_style = "friendly"
pygments_dark_style = "native"
