"""One sitting: a scene, a method, what came of it, and what waits for the worker."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from flatland.field import Field
from flatland.grid import Grid
from flatland.scene import Scene
from gui.models.choice import Choice
from gui.models.display import Display, Look
from gui.models.document import SceneDocument
from gui.models.events import Event
from gui.models.frame import Frame
from gui.models.jobs import Job
from gui.models.levels import coarsened, ratio_of
from gui.models.plane import Plane
from gui.models.selection import Selection
from gui.models.tools import Brush, Tool
from gui.models.track import Row, Track

#: Steps that may wait while the worker is busy; further key presses are dropped.
MOST_WAITING = 3


class Runner(Protocol):
    """Who does jobs, elsewhere, and calls the session back on its own thread."""

    def submit(self, job: Job) -> None: ...

    def cancel(self) -> None: ...

    @property
    def waiting(self) -> int: ...


@dataclass(frozen=True, eq=False)
class KeptRun:
    """A run that is kept to compare with: drawn over the cells and in the curves."""

    label: str
    scheme: str
    field: Field
    track: Track
    scene: Scene
    visible: bool = True


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
        self.exact: Field | None = None
        self.stamp = 0
        self.busy = ""
        self.computing_reference = False
        self.wants_reference = False
        #: Whether the run in hand goes on until paused.
        self.runs_freely = False
        self.runner: Runner | None = None
        self.reference_runner: Runner | None = None
        self.framed, self.busy_changed, self.method_changed = Event(), Event(), Event()
        self.tracked, self.references_changed, self.runs_changed = Event(), Event(), Event()
        self.tool_changed, self.noticed, self.failed = Event(), Event(), Event()
        self.progressed = Event()
        self._made: dict[str, tuple[Any, Field, Field | None]] = {}
        self._exact_key: tuple[Any, ...] | None = None
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
    def iteration(self) -> int:
        return self.frame.iteration if self.frame else 0

    def field(self, view: str) -> Field | None:
        """What a view shows; None as long as there is nothing."""
        if view == "reference":
            return self._exact_there()
        if view == "difference":
            return self._difference()
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

    def _exact_there(self) -> Field | None:
        """The exact field on the level on show."""
        if self.exact is None or not self.level:
            return self.exact
        return self._derived(("exact", self.level), lambda e: coarsened(e, self.level or 0))

    def _difference(self) -> Field | None:
        field, exact = self.field("accumulated"), self._exact_there()
        if field is None or exact is None or field.values.shape != exact.values.shape:
            return None
        key = ("difference", id(field))
        return self._derived(
            key, lambda _: Field(field.grid, field.basis, field.values - exact.values), field
        )

    def _derived(
        self, key: tuple[Any, ...], make: Callable[[Field], Field], keep: Field | None = None
    ) -> Field:
        """A field made from others, kept as long as these are on show."""
        assert self.exact is not None
        known = self._made.get(key[0])
        if known is None or known[0] != (key, id(self.exact)):
            known = (key, id(self.exact)), make(self.exact), keep
            self._made[key[0]] = known
        return known[1]

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
        if self._exact_key != self._reference_key():
            self.exact, self._exact_key = None, None
            if self.computing_reference and self.reference_runner is not None:
                self.reference_runner.cancel()
            self.references_changed.emit()
        self.framed.emit()
        self.tracked.emit()
        self.begin()
        if self.exact is not None:
            self._send_exact()
        elif self.wants_reference:
            self.compute_reference()

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

    def compute_reference(self) -> None:
        """The exact field at the bands of the method, computed beside the run."""
        self.wants_reference = True
        if self.reference_runner is None or self._exact_key == self._reference_key():
            return
        if not self.computing_reference:
            self.computing_reference = True
            job = Job("reference", self.scene, self.choice, self.stamp)
            self.reference_runner.submit(job)
            self.references_changed.emit()

    def stop_reference(self) -> None:
        """No exact answer after all."""
        self.wants_reference = False
        if self.reference_runner is not None:
            self.reference_runner.cancel()

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

    def take_reference(self, job: Job, exact: Field | None) -> None:
        """The exact field of a job's scene; None if it was cancelled or cannot be had."""
        self.computing_reference = False
        fits = self._key_of(job) == self._reference_key()
        if exact is not None and fits:
            self.exact, self._exact_key = exact, self._key_of(job)
            self._send_exact()
        self.references_changed.emit()
        if not fits and self.wants_reference:
            self.compute_reference()

    def take_failure(self, stamp: int, title: str, text: str, details: str) -> None:
        if stamp == self.stamp or not stamp:
            self.failed.emit(title, text, details)

    def _send_exact(self) -> None:
        if self.choice.steps and self.exact is not None:
            self.submit("measure", exact=self.exact)

    def _reference_key(self) -> tuple[Any, ...]:
        return (self.scene, self.choice.bands, self.choice.bounces)

    @staticmethod
    def _key_of(job: Job) -> tuple[Any, ...]:
        return (job.scene, job.choice.bands, job.choice.bounces)

    # -- the same from a script -----------------------------------------------------------------

    def command_line(self) -> str:
        """The command that gives the numbers on show; the scene's text goes before it if no file
        has it."""
        return command_line(self.document, self.choice, self.frame)


def command_line(document: SceneDocument, choice: Choice, frame: Frame | None) -> str:
    """`flatland run ...` for a scene, a method and where its run stands."""
    name = document.command_name
    words = ["flatland", "run", name or "scene.toml", *choice.arguments()]
    if choice.steps:
        if frame is not None and frame.converged is not None:
            words += ["--converge", f"{frame.converged.tolerance:g}"]
        else:
            words += ["--iterations", str(frame.iteration if frame else 0)]
    line = shlex.join(words)
    if name is not None:
        return line
    return f"cat > scene.toml <<'SCENE'\n{document.text.rstrip()}\nSCENE\n{line}"
