"""What every view has to draw: layers made once per field, and the scale they share."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

from flatland.field import Field
from gui.models.display import VIEWS
from gui.models.session import Session
from gui.render.colours import Palette, mixed
from gui.render.picture import Cut, Layer, Scale, cut_of
from gui.render.scaling import fitted_top
from studies.lines import line_of

#: Cuts that are kept; each holds a float32 copy of its cells.
_KEPT = 16


class Stage:
    """Layers and scales of a session's views, for a palette."""

    def __init__(self, session: Session, palette: Palette) -> None:
        self.session, self.palette = session, palette
        self._cuts: OrderedDict[tuple[Any, ...], tuple[Field, Cut]] = OrderedDict()

    def layers(self, view: str, ratio: float = 1.0) -> list[Layer]:
        """What to draw in a view, back to front; lines `ratio` times as wide."""
        session, field = self.session, self.session.field(view)
        if field is None:
            return []
        scheme = "analytic" if view == "reference" else session.choice.propagator
        colour, cut = self.colour_of(scheme), self._cut(field)
        if not self._overlaid(view):
            return [Layer(cut, colour, hued=True)]
        layers = [Layer(cut, colour, opacity=0.35)]
        exact = session.field("reference")
        if exact is not None:
            layers.insert(0, Layer(self._cut(exact), self.palette.exact))
        for run in session.overlays():
            other = self._cut(run.field)
            layers.append(Layer(other, self.colour_of(run.scheme), width=1.3 * ratio))
        return [*layers, Layer(cut, colour, width=1.6 * ratio)]

    def legend(self, view: str) -> list[tuple[str, str]]:
        """Colours and names of what shares the cells of a view; none if nothing does."""
        if self.session.field(view) is None or not self._overlaid(view):
            return []
        entries = []
        if self.session.exact is not None:
            entries.append((self.palette.exact, "exact"))
        runs = self.session.overlays()
        entries += [(self.colour_of(run.scheme), run.label) for run in runs]
        choice = self.session.choice
        return [*entries, (self.colour_of(choice.propagator), choice.label)]

    def _overlaid(self, view: str) -> bool:
        """Whether other fields share the cells of a view."""
        if view != "accumulated" or not self.session.display.look.overlay:
            return False
        return self.session.exact is not None or bool(self.session.overlays())

    def main(self, view: str) -> Cut | None:
        """The light of a view itself."""
        field = self.session.field(view)
        return None if field is None else self._cut(field)

    def scale(self, view: str) -> Scale:
        """How sizes are shown in a view."""
        look = self.session.display.look
        return Scale(self.top(view), look.scale, look.decades, look.spread == "per cell")

    def top(self, view: str) -> float:
        """The intensity of a full lobe: set by hand, or the largest of what is on show."""
        look = self.session.display.look
        if look.top is not None and look.spread != "per view":
            return look.top
        views = [view] if look.spread == "per view" else [*look.views, "accumulated"]
        mains = [self.main(each) for each in dict.fromkeys(views) if each in VIEWS]
        return max((fitted_top(each.peaks) for each in mains if each is not None), default=1.0)

    def colour_of(self, scheme: str) -> str:
        """A scheme's colour in the project's figures, light enough for a dark ground."""
        colour = line_of(scheme).colour
        return mixed(colour, "#ffffff", 0.3) if self.palette.dark else colour

    def _cut(self, field: Field) -> Cut:
        look, plane = self.session.display.look, self.session.plane_on(field.grid)
        key = (id(field), plane, look.channel)
        if key not in self._cuts:
            self._cuts[key] = field, cut_of(field, plane, look.channel)
            while len(self._cuts) > _KEPT:
                self._cuts.popitem(last=False)
        self._cuts.move_to_end(key)
        return self._cuts[key][1]
