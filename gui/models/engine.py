"""What the worker does: owns the simulation, and answers one job after another."""

from __future__ import annotations

import time
from collections.abc import Callable

from flatland.errors import InstabilityError, bad_input
from flatland.field import Field
from flatland.scene import Scene
from flatland.simulation import Simulation
from flatland.solvers.watching import watched
from gui.models import levels
from gui.models.choice import Choice
from gui.models.exact import answer
from gui.models.frame import Frame, flux_balance, frame_of
from gui.models.helper import ask
from gui.models.history import History
from gui.models.jobs import Cancelled, Job, Watch
from gui.models.listening import listening
from gui.models.measures import errors_of
from gui.models.track import Row
from propagators import StencilPropagator

#: Seconds between two frames that are handed over while a run goes on.
FRAME_SECONDS = 1 / 30
#: Seconds of stepping between two looks at whether to stop, at most one step if it is longer.
_SLICE = 0.02


class Engine:
    """One simulation at a time, used by one thread at a time."""

    def __init__(self, history: History | None = None) -> None:
        self.history = history or History()
        self.simulation: Simulation | None = None
        #: The exact field at the bands of the method, once somebody computed it.
        self.exact: Field | None = None
        self._key: tuple[Scene, Choice] | None = None
        self._rows: list[Row] = []
        self._pace = float("nan")

    def perform(self, job: Job, watch: Watch) -> None:
        """Do a job. Raises what the engine raises, and Cancelled."""
        actions: dict[str, Callable[..., None]] = {
            "inject": self.inject,
            "downsample": self.downsample,
            "step": self.step,
            "run": self.run,
            "solve": self.solve,
            "go_to": self.go_to,
            "measure": self.measure,
        }
        with listening(watch.notice):
            self._prepare(job)
            if self.simulation is None and job.kind != "measure":
                self._answer(job, watch)
            else:
                actions[job.kind](watch, **job.arguments)

    # -- actions --------------------------------------------------------------------------------

    def inject(self, watch: Watch, fill: bool = True) -> None:
        """Iteration 0: the lights in their cells. fill: on all levels, not on the finest alone."""
        simulation = self._stepped()
        if fill:
            levels.start(simulation)
        else:
            simulation.inject()
        self.history.clear()
        self._enter(simulation)
        self._publish(watch)

    def downsample(self, watch: Watch) -> None:
        """Fill the coarse levels with what is on the finest now."""
        simulation = self._stepped()
        if levels.count_of(simulation) > 1 and simulation.converged is None:
            levels.downsample(simulation)
            self.history.mark(simulation)
            self._publish(watch)

    def step(self, watch: Watch, count: int = 1) -> None:
        """`count` more iterations, as fast as they go."""
        self.run(watch, count)

    def run(self, watch: Watch, count: int | None = None, rate: float | None = None) -> None:
        """`count` iterations, or until cancelled; at most `rate` per second."""
        simulation = self._stepped()
        if simulation.converged is not None or not self.history.key_frames:
            self.inject(watch)
        start, done, shown = simulation.iteration, 0, 0.0
        try:
            while count is None or done < count:
                begin = time.perf_counter()
                self._step_once(simulation)
                done = simulation.iteration - start
                now = time.perf_counter()
                self._pace = now - begin
                if rate is not None or now - shown >= FRAME_SECONDS:
                    self._publish(watch)
                    watch.progress(done, count or 0)
                    shown = now
                if watch.cancelled():
                    raise Cancelled
                if rate is not None:
                    watch.sleep(max(0.0, 1 / rate - (time.perf_counter() - begin)))
        except InstabilityError as error:
            watch.notice(str(error))
            self._publish(watch, unstable_at=simulation.iteration)
            return
        finally:
            if watch.cancelled():
                self._publish(watch)
        self._publish(watch)

    def solve(self, watch: Watch, tolerance: float = 1e-8) -> None:
        """The converged field; the run's history is left as it is."""
        simulation = self._stepped()
        applications = 0

        def advance(count: int) -> None:
            nonlocal applications
            applications += count
            watch.progress(applications, 0)
            if watch.cancelled():
                raise Cancelled

        try:
            with watched(advance):
                simulation.solve(tolerance)
        except Cancelled:
            self._recover(simulation)
            raise
        self._publish(watch)

    def go_to(self, watch: Watch, iteration: int) -> None:
        """An iteration that was reached before."""
        simulation = self._stepped()
        if not 0 <= iteration <= self.history.reached:
            rule = f"must be from 0 to {self.history.reached}, the last one reached"
            raise bad_input("iteration", iteration, rule)
        self.history.go_to(simulation, iteration)
        self._publish(watch)

    def measure(self, watch: Watch, exact: Field) -> None:
        """Take the exact field and fill in the errors of all iterations so far."""
        self.exact = exact
        simulation = self.simulation
        if simulation is None or not self.history.key_frames:
            return
        now, solved = simulation.iteration, simulation.converged is not None
        if solved:
            return
        last = self.history.reached
        try:
            for iteration in range(last + 1):
                self.history.go_to(simulation, iteration)
                self._rows.append(self._row(simulation))
                watch.progress(iteration, last)
                if watch.cancelled():
                    raise Cancelled
        finally:
            self.history.go_to(simulation, now)
        self._publish(watch)

    # -- helpers --------------------------------------------------------------------------------

    def _prepare(self, job: Job) -> None:
        """The simulation of the job's scene and method; a new one only if these changed."""
        if self._key == (job.scene, job.choice):
            return
        self._key = None
        self.simulation, self.exact, self._rows = None, None, []
        self.history.clear()
        method = job.choice.method()
        if isinstance(method.propagator, StencilPropagator):
            self.simulation = method.simulation(job.scene)
        self._key = (job.scene, job.choice)

    def _stepped(self) -> Simulation:
        if self.simulation is None:
            rule = "answers a scene at once and has no iterations"
            raise bad_input("propagator", self._key[1].propagator if self._key else "", rule)
        return self.simulation

    def _answer(self, job: Job, watch: Watch) -> None:
        """Of a method without steps."""
        begin = time.perf_counter()
        found = ask(
            answer,
            job.scene,
            job.choice,
            wanted=lambda: not watch.cancelled(),
            tell=watch.notice,
        )
        if found is None:
            raise Cancelled
        seconds = time.perf_counter() - begin
        fields = {"accumulated": found.field}
        watch.publish(Frame(fields, ledger=found.ledger, seconds_per_step=seconds), [])

    def _step_once(self, simulation: Simulation) -> None:
        simulation.run(1)
        self.history.passed(simulation)
        self._enter(simulation)

    def _enter(self, simulation: Simulation) -> None:
        """Book an iteration in history and curves."""
        self.history.record(simulation)
        self._rows.append(self._row(simulation))

    def _row(self, simulation: Simulation) -> Row:
        values = flux_balance(simulation.ledger)
        values.pop("closure", None)
        if self.exact is not None:
            values.update(self._errors(simulation, self.exact))
        return Row(simulation.iteration, values)

    def _errors(self, simulation: Simulation, exact: Field) -> dict[str, float]:
        """Errors of the field, and of every level as `name@level`."""
        if levels.count_of(simulation) == 1:
            return errors_of(simulation.accumulated, exact)
        found = errors_of(levels.merged_fields(simulation, None)["accumulated"], exact)
        for number, fields in enumerate(levels.level_fields(simulation)):
            each = errors_of(fields["accumulated"], levels.coarsened(exact, number))
            found |= {f"{name}@{number}": value for name, value in each.items()}
        return found

    def _recover(self, simulation: Simulation) -> None:
        """After a cancelled solve: back to the last iteration of the run."""
        if self.history.key_frames:
            self.history.go_to(simulation, self.history.reached)
        else:
            simulation.reset()

    def _publish(self, watch: Watch, unstable_at: int | None = None) -> None:
        rows, self._rows = self._rows, []
        watch.publish(frame_of(self._stepped(), self._pace, unstable_at), rows)
