"""One sitting: a scene, a method, what came of it, and what waits for the worker."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from flatland.field import Field
from flatland.grid import Grid
from flatland.scene import Scene
from gui.models.choice import Choice
from gui.models.display import Display, Look
from gui.models.document import SceneDocument
from gui.models.events import Event
from gui.models.frame import Frame
from gui.models.jobs import Job, Runner
from gui.models.kept import KeptRun
from gui.models.levels import ratio_of
from gui.models.plane import Plane
from gui.models.reference import Reference
from gui.models.script import command_line
from gui.models.selection import Selection
from gui.models.tools import Brush, Tool
from gui.models.track import Row, Track

#: Steps that may wait while the worker is busy; further key presses are dropped.
MOST_WAITING = 3


class Session:
    """Binds document, choice and display to the worker's answers.

    Events: `framed` (new fields), `busy_changed`, `method_changed`, `tracked` (new curve rows),
    `references_changed`, `runs_changed`, `tool_changed`, `noticed` (text), `failed` (title, text,
    details), `progressed` (done, total; total 0 if unknown).
    """

    def __init__(self, document: SceneDocument | None = None, look: Look | None = None) -> None:
        self.document = document or SceneDocument()
        self.display = Display(look)
        self.selection = Selection()
        self.brush, self.tool = Brush(), Tool.SELECT
        self.choice = Choice().fitting(self.document.scene)
        self.frame: Frame | None = None
        self.track = Track(self.choice.label)
        self.runs: list[KeptRun] = []
        self.reference = Reference(self)
        self.stamp = 0
        self.busy = ""
        #: Whether the run in hand goes on until paused.
        self.runs_freely = False
        self.runner: Runner | None = None
        self.framed, self.busy_changed, self.method_changed = Event(), Event(), Event()
        self.tracked, self.references_changed, self.runs_changed = Event(), Event(), Event()
        self.tool_changed, self.noticed, self.failed = Event(), Event(), Event()
        self.progressed = Event()
        self._scene = self.document.scene
        self.document.changed.connect(self._scene_changed)

    # -- what is looked at ----------------------------------------------------------------------

    @property
    def scene(self) -> Scene:
        return self.document.scene

    @property
    def plane(self) -> Plane:
        look = self.display.look
        return Plane.of(self.scene.grid, look.normal, look.layer)

    @property
    def exact(self) -> Field | None:
        return self.reference.field

    @property
    def iteration(self) -> int:
        return self.frame.iteration if self.frame else 0

    def field(self, view: str) -> Field | None:
        """What a view shows; None as long as there is nothing."""
        if view == "reference":
            return self.reference.on(self.level)
        if view == "difference":
            return self.reference.difference(self.field("accumulated"), self.level)
        if self.frame is None:
            return None
        fields = self.frame.fields if self.level is None else self.frame.levels[self.level]
        return fields.get(view)

    @property
    def level(self) -> int | None:
        """The octree level on show; None for the merged field, or the only one."""
        level = self.display.look.level
        count = len(self.frame.levels) if self.frame else 0
        return level if level is not None and level < count else None

    def overlays(self) -> list[KeptRun]:
        """Kept runs that fit into the cells on show."""
        if self.level:
            return []
        grid = self.scene.grid
        return [run for run in self.runs if run.visible and run.field.grid == grid]

    def plane_on(self, grid: Grid) -> Plane:
        """The plane that is looked at, on the grid of a level."""
        plane = self.plane
        return replace(plane, layer=plane.layer // ratio_of(grid, self.scene.grid))

    # -- the method -----------------------------------------------------------------------------

    def choose(self, choice: Choice) -> None:
        """Another method. Raises InputError and then changes nothing."""
        choice.method()
        if choice != self.choice:
            self.choice = choice
            self._outdated()
            self.method_changed.emit()

    def set_tool(self, tool: Tool) -> None:
        if tool != self.tool:
            self.tool = tool
            self.tool_changed.emit()

    def _scene_changed(self) -> None:
        """The light on show is no longer that of the scene."""
        if self.document.scene == self._scene:
            return
        self._scene = self.document.scene
        choice = self.choice.fitting(self._scene)
        if choice != self.choice:
            self.choice = choice
            self.method_changed.emit()
        self._outdated()

    def _outdated(self) -> None:
        """Drop what belongs to another scene or method, and show iteration 0 of this one."""
        self.stamp += 1
        if self.runner is not None:
            self.runner.cancel()
        self.frame = None
        self.track = Track(self.choice.label)
        self.reference.drop_outdated()
        self.framed.emit()
        self.tracked.emit()
        self.begin()
        self.reference.renew()

    # -- wishes ---------------------------------------------------------------------------------

    def submit(self, kind: str, **arguments: Any) -> None:
        """Ask the worker for something."""
        if self.runner is not None:
            self.runner.submit(Job(kind, self.scene, self.choice, self.stamp, arguments))

    def begin(self) -> None:
        """Iteration 0, all levels filled: where every run begins."""
        self.submit("inject" if self.choice.steps else "solve")

    def inject(self) -> None:
        """Back to iteration 0: the lights in their cells, empty history."""
        self.cancel()
        self.track.clear()
        self.tracked.emit()
        if self.choice.steps:
            self.submit("inject", fill=False)
        else:
            self.submit("solve")

    def downsample(self) -> None:
        """Fill the coarse levels by hand."""
        self.submit("downsample")

    def reset(self) -> None:
        """No light at all: dark grids, and no curves."""
        self.cancel()
        self.frame = None
        self.track.clear()
        self.framed.emit()
        self.tracked.emit()

    def step(self, count: int = 1) -> None:
        if self.runner is not None and self.runner.waiting < MOST_WAITING:
            self.submit("step", count=count)

    def step_back(self, count: int = 1) -> None:
        if self.frame is None:
            return
        if self.frame.converged is not None:
            self.go_to(self.last_iteration)
        elif self.iteration > 0:
            self.go_to(max(0, self.iteration - count))

    @property
    def last_iteration(self) -> int:
        """The latest iteration that was reached."""
        return max(self.track.rows, default=0)

    def go_to(self, iteration: int) -> None:
        """Any iteration that was reached before; only the newest wish counts."""
        if self.runner is not None and not self.busy.startswith(("run", "solve")):
            self.submit("go_to", iteration=min(max(iteration, 0), self.last_iteration))

    def run(self, count: int | None = None) -> None:
        """Until paused, at the display's rate; or `count` iterations at full speed."""
        self.runs_freely = count is None
        rate = self.display.look.rate if count is None else None
        self.submit("run", count=count, rate=rate)

    def solve(self, tolerance: float = 1e-8) -> None:
        self.submit("solve", tolerance=tolerance)

    def cancel(self) -> None:
        """Stop whatever the worker does; nothing is lost but what was not done yet."""
        if self.runner is not None:
            self.runner.cancel()

    def keep_run(self) -> KeptRun | None:
        """Keep what is on show, to compare the next with."""
        if self.frame is None:
            return None
        kept = KeptRun(
            self.choice.label,
            self.choice.propagator,
            self.frame.accumulated,
            Track(self.choice.label, dict(self.track.rows)),
            self.scene,
        )
        self.runs.append(kept)
        self.runs_changed.emit()
        return kept

    def drop_run(self, index: int) -> None:
        del self.runs[index]
        self.runs_changed.emit()

    # -- answers --------------------------------------------------------------------------------

    def take_frame(self, stamp: int, frame: Frame, rows: list[Row]) -> None:
        """What the worker handed over; dropped if scene or method changed meanwhile."""
        if stamp != self.stamp:
            return
        if rows and rows[0].iteration == 0 and len(rows) <= 1:
            self.track.clear()
        self.frame = frame
        if rows:
            self.track.add(rows)
            self.tracked.emit()
        self.framed.emit()

    def take_busy(self, kind: str) -> None:
        """The job that the worker is at, or "" if it has none."""
        if kind != self.busy:
            self.busy = kind
            self.busy_changed.emit()

    def take_failure(self, stamp: int, title: str, text: str, details: str) -> None:
        if stamp == self.stamp or not stamp:
            self.failed.emit(title, text, details)

    # -- the same from a script -----------------------------------------------------------------

    def command_line(self) -> str:
        """The command that gives the numbers on show; the scene's text goes before it if no file
        has it."""
        return command_line(self.document, self.choice, self.frame)
