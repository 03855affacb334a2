"""How it is shown."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication

from gui.commands.base import Commands
from gui.models.display import HEAT
from gui.models.tools import Tool
from gui.theme import apply_theme, is_dark


class ViewCommands(Commands):
    """The View and Tools menus."""

    _before: tuple[str, ...] = ()

    def tool(self, name: str) -> None:
        self.session.set_tool(Tool[name])
        for canvas in self.window.views.canvases.values():
            self.window.mouse.set_cursor(canvas)

    def view(self, name: str) -> None:
        self.session.display.toggle("views", name)
        if name in ("reference", "difference") and name in self.session.display.look.views:
            self.session.reference.compute()

    def one_view(self, name: str = "accumulated") -> None:
        """One view alone; once more: those that were on show before."""
        shown = self.session.display.look.views
        if shown == (name,) or (len(shown) == 1 and self._before):
            self.session.display.set(views=self._before or ("source", "target", "accumulated"))
        else:
            self._before = shown
            self.session.display.set(views=(name,))

    def fit(self) -> None:
        self.window.camera.refit()
        self.window.views.fit_if_wanted()

    def zoom_in(self) -> None:
        self.window.camera.zoom_by(1, self.window.camera.centre)

    def zoom_out(self) -> None:
        self.window.camera.zoom_by(-1, self.window.camera.centre)

    def scale_kind(self) -> None:
        now = self.session.display.look.scale
        self.session.display.set(scale="linear" if now == "logarithmic" else "logarithmic")

    def larger(self) -> None:
        self.session.display.set(top=self.window.stage.top("accumulated") / 2)

    def smaller(self) -> None:
        self.session.display.set(top=self.window.stage.top("accumulated") * 2)

    def fit_scale(self) -> None:
        self.session.display.set(top=None)

    def heat(self) -> None:
        now = HEAT.index(self.session.display.look.heat)
        self.session.display.set(heat=HEAT[(now + 1) % len(HEAT)])
        self.say(f"heat map: {self.session.display.look.heat}")

    def overlay(self) -> None:
        self.session.display.set(overlay=not self.session.display.look.overlay)

    def layer(self, name: str) -> None:
        self.session.display.toggle("layers", name)

    def slice_axis(self) -> None:
        if self._solid():
            self.session.display.set(normal=(self.session.display.look.normal + 1) % 3, layer=None)

    def slice_up(self) -> None:
        self._slice(1)

    def slice_down(self) -> None:
        self._slice(-1)

    def _slice(self, change: int) -> None:
        plane = self.session.plane
        if self._solid() and plane.normal is not None:
            last = self.session.scene.grid.shape[plane.normal] - 1
            self.session.display.set(layer=min(max(plane.layer + change, 0), last))

    def _solid(self) -> bool:
        solid = self.session.scene.grid.dimension == 3
        if not solid:
            self.say("a 2D grid has no slices")
        return solid

    def level(self) -> None:
        count = self.session.choice.levels
        if count == 1:
            self.say("a uniform grid has one level")
            return
        now = self.session.level
        following = 0 if now is None else now + 1
        self.session.display.set(level=following if following < count else None)

    def theme(self) -> None:
        """Light or dark, the other one."""
        settings = self.window.settings
        settings.theme = "light" if is_dark(settings.theme) else "dark"
        settings.save()
        self.show_theme()

    def show_theme(self) -> None:
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        palette = apply_theme(application, self.window.settings.theme)
        self.window.stage.palette = palette
        self.window.inspector.refresh()
        self.window.curves.refresh()
        self.window.runs_panel.refresh()
        self.window.views.repaint_views()

    def reset_layout(self) -> None:
        self.window.reset_layout()
