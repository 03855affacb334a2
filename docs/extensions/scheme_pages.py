"""Directives that write what the registries know.

`schemes`: a table of all propagators. `scheme NAME`: dimensions, options and class of one of them.
`scene-keys lights` or `occluders`: the keys of each kind, as a scene file has them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

_LOG = logging.getLogger(__name__)
#: Bands whose spectral radius is shown, by dimension.
_BANDS = {2: range(1, 9), 3: range(1, 6)}


class SchemesDirective(SphinxDirective):
    """`schemes`."""

    def run(self) -> list[nodes.Node]:
        from propagators.registry import BUILT_IN, find

        rows = ["| scheme | in | how | what it is |", "| --- | --- | --- | --- |"]
        for name in BUILT_IN:
            scheme = find(name)
            if not (Path(self.env.srcdir) / "schemes" / f"{name}.md").exists():
                _LOG.warning("schemes: %s has no page", name, location=self.get_location())
                continue
            rows.append(
                f"| [{name}](/schemes/{name}.md) | {_dimensions(scheme)} | {_manner(scheme)} | "
                f"{scheme.summary} |"
            )
        return self.parse_text_to_nodes("\n".join(rows))


class SchemeDirective(SphinxDirective):
    """`scheme NAME`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        from propagators.registry import find

        name = self.arguments[0]
        scheme = find(name)
        place = f"{scheme.__module__}.{scheme.__qualname__}"
        text = [
            f"`{name}` works in {_dimensions(scheme)} and {_MANNERS[_manner(scheme)]}.",
            "",
            *self._radii(name, scheme),
            *_options(scheme),
            "",
            "```{eval-rst}",
            f".. autoclass:: {place}()",
            "```",
        ]
        return self.parse_text_to_nodes("\n".join(text))

    def _radii(self, name: str, scheme: Any) -> list[str]:
        """The growth per step of a stencil scheme's fastest growing wave, by bands."""
        if _manner(scheme) != "stepped" or self.env.app.tags.has("quick"):
            return []
        lines = []
        for dimension in scheme.dimensions:
            radii = [f"{_radius(name, dimension, n):.4f}" for n in _BANDS[dimension]]
            head = " | ".join(map(str, _BANDS[dimension]))
            lines += [
                f"| bands, {dimension}D | {head} |",
                "| --- |" + " --- |" * len(radii),
                f"| spectral radius | {' | '.join(radii)} |",
                "",
            ]
        return lines


class SceneKeysDirective(SphinxDirective):
    """`scene-keys lights` or `scene-keys occluders`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        from flatland.injectors import INJECTORS
        from flatland.occluders import OCCLUDERS

        kinds: dict[str, Any] = {"lights": INJECTORS, "occluders": OCCLUDERS}[self.arguments[0]]
        text = []
        for name, kind in kinds.items():
            summary = (kind.__doc__ or "").strip().splitlines()[0]
            text += [f"**`{name}`** ({_dimensions(kind)}). {summary}", "", *_keys(kind), ""]
        return self.parse_text_to_nodes("\n".join(text))


_MANNERS = {
    "stepped": "is stepped through the grid, or solved to convergence",
    "at once": "answers a scene at once; it has no iterations",
}


def _manner(scheme: Any) -> str:
    from propagators import StencilPropagator

    return "stepped" if issubclass(scheme, StencilPropagator) else "at once"


def _dimensions(kind: Any) -> str:
    return " and ".join(f"{dimension}D" for dimension in kind.dimensions)


def _radius(name: str, dimension: int, bands: int) -> float:
    import propagators
    from flatland.harmonics import basis_for

    return propagators.create(name).stencil(basis_for(dimension, bands)).spectral_radius()


def _options(scheme: Any) -> list[str]:
    if not scheme.options:
        return ["It has no options."]
    rows = ["| option | default | accepted | what it is |", "| --- | --- | --- | --- |"]
    for option in scheme.options:
        default = str(option.default).lower() if option.type is bool else option.default
        rows.append(f"| `{option.name}` | `{default}` | {_accepted(option)} | {option.meaning} |")
    return rows


def _accepted(option: Any) -> str:
    if option.choices:
        return ", ".join(f"`{choice}`" for choice in option.choices)
    if option.type is bool:
        return "`true`, `false`"
    kind = {int: "whole number", float: "number", str: "text"}[option.type]
    if option.minimum is None and option.maximum is None:
        return kind
    if option.maximum is None:
        return f"{kind}, at least {option.minimum:g}"
    if option.minimum is None:
        return f"{kind}, at most {option.maximum:g}"
    return f"{kind}, {option.minimum:g} to {option.maximum:g}"


def _keys(kind: Any) -> list[str]:
    rows = ["| key | default | what it is |", "| --- | --- | --- |"]
    for name, field in kind.model_fields.items():
        if name == "kind":
            continue
        default = "needed" if field.is_required() else f"`{_shown(field.default)}`"
        rows.append(f"| `{field.alias or name}` | {default} | {field.description} |")
    return rows


def _shown(default: Any) -> str:
    if default is None or default == ():
        return "-"
    return str(default).lower() if isinstance(default, bool) else str(default)


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the directives."""
    app.add_directive("schemes", SchemesDirective)
    app.add_directive("scheme", SchemeDirective)
    app.add_directive("scene-keys", SceneKeysDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
