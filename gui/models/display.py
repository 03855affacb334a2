"""How fields are shown: views, scale, layers. Changing it never changes a number of the run."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from gui.models.events import Event

#: Views of a run, in the order in which they stand side by side.
VIEWS = ("source", "target", "accumulated", "reference", "difference")
MEANINGS = {
    "source": "Light one iteration before",
    "target": "Newest light, still to move",
    "accumulated": "Sum of all iterations, what is compared with the exact answer",
    "reference": "The exact answer, cut to the method's bands",
    "difference": "Accumulated minus exact",
}
#: Parts of the scene and of the grid that can be drawn over the light.
LAYERS = {
    "grid": "Borders of cells",
    "lights": "Lights",
    "occluders": "Occluders",
    "injected": "Cells that got light, with its mean direction",
}
SCALES = ("linear", "logarithmic")
SPREADS = {
    "shared": "one scale for all views",
    "per view": "every view fills its own range",
    "per cell": "every lobe fills its cell: shapes alone",
}
HEAT = ("off", "under lobes", "instead of lobes")


@dataclass(frozen=True)
class Look:
    """All settings of the display, as a value.

    top: the intensity [W per unit angle] whose lobe reaches the side of its cell; None: fitted to
    the light. decades: from there to the middle on the logarithmic scale.
    channel: of colours, or None for their sum. rate: iterations per second of `run`, None: as fast
    as they go.
    """

    views: tuple[str, ...] = ("source", "target", "accumulated")
    scale: str = "logarithmic"
    spread: str = "shared"
    top: float | None = None
    decades: float = 4.0
    heat: str = "off"
    layers: tuple[str, ...] = ("grid", "lights", "occluders")
    overlay: bool = True
    channel: int | None = None
    normal: int = 2
    layer: int | None = None
    level: int | None = None
    rate: float | None = 30.0


class Display:
    """The look, and who wants to know of changes."""

    def __init__(self, look: Look | None = None) -> None:
        self.look = look or Look()
        self.changed = Event()

    def set(self, **values: Any) -> None:
        """Change settings; tells nobody if nothing changed."""
        look = replace(self.look, **values)
        if look != self.look:
            self.look = look
            self.changed.emit()

    def toggle(self, name: str, entry: str) -> None:
        """Show or hide a view or a layer; the last view stays."""
        order = {"views": VIEWS, "layers": tuple(LAYERS)}[name]
        now = set(getattr(self.look, name)) ^ {entry}
        if now or name != "views":
            self.set(**{name: tuple(each for each in order if each in now)})


def look_from(values: Any) -> Look:
    """Settings as they were stored; what does not fit is left at its default."""
    if not isinstance(values, dict):
        return Look()
    good: dict[str, Any] = {}
    for item in fields(Look):
        value = values.get(item.name)
        value = tuple(value) if isinstance(value, list) else value
        if item.name in values and _fits(item.name, value):
            good[item.name] = value
    return Look(**good)


def _fits(name: str, value: Any) -> bool:
    choices: dict[str, Any] = {"scale": SCALES, "spread": tuple(SPREADS), "heat": HEAT}
    if name in choices:
        return value in choices[name]
    if name in ("views", "layers"):
        known = VIEWS if name == "views" else tuple(LAYERS)
        return (
            isinstance(value, tuple)
            and all(v in known for v in value)
            and bool(value or name == "layers")
        )
    if name == "overlay":
        return isinstance(value, bool)
    if name == "decades":
        return _number(value) and 0.5 <= value <= 16
    if name == "rate":
        return value is None or (_number(value) and 0.1 <= value <= 1000)
    return False  # what belongs to one scene is not kept


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
