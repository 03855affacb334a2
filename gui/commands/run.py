"""Stepping, solving, going back, the exact answer."""

from __future__ import annotations

from gui.commands.base import Commands

#: Paces of `Faster` and `Slower` [iterations per second]; the last is full speed.
RATES = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 250.0, 500.0, 1000.0, None)


class RunCommands(Commands):
    """The Run menu."""

    def _steps(self) -> bool:
        if not self.session.choice.steps:
            self.say(f"{self.session.choice.propagator} answers at once and has no iterations: I")
        return self.session.choice.steps

    def run(self) -> None:
        """Run, or pause."""
        if self.session.busy in ("run", "solve"):
            self.session.cancel()
        elif self._steps():
            self.session.run()

    def run_count(self) -> None:
        if self._steps() and self.session.busy not in ("run", "solve"):
            self.session.run(self.window.timeline.count.value())

    def step(self) -> None:
        if self._steps():
            self.session.step()

    def step_many(self) -> None:
        if self._steps():
            self.session.step(10)

    def back(self) -> None:
        self.session.step_back()

    def back_many(self) -> None:
        self.session.step_back(10)

    def first(self) -> None:
        if self.session.frame is not None and self.session.choice.steps:
            self.session.go_to(0)

    def last(self) -> None:
        if self.session.frame is not None and self.session.choice.steps:
            self.session.go_to(self.session.last_iteration)

    def solve(self) -> None:
        if self.session.busy not in ("run", "solve"):
            self.session.solve()

    def stop(self) -> None:
        """The stroke in hand, else the run, else the selection."""
        if self.window.mouse.drawing:
            self.window.mouse.drop()
            self.window.views.repaint_views()
        elif self.session.busy:
            self.session.cancel()
        elif self.session.reference.computing:
            self.session.reference.stop()
        elif self.session.selection.items:
            self.session.selection.set(())
        else:
            self.session.selection.pin(None)

    def inject(self) -> None:
        self.session.inject()
        if self.session.choice.levels > 1 and self.session.choice.steps:
            self.say("injected into level 0; D fills the coarser levels")

    def reset(self) -> None:
        self.session.reset()

    def downsample(self) -> None:
        if self._has_levels("downsample"):
            self.session.downsample()

    def merge(self) -> None:
        """Look at the field that is read from all levels."""
        if self._has_levels("merge"):
            self.session.display.set(level=None)

    def _has_levels(self, what: str) -> bool:
        several = self.session.choice.levels > 1
        if not several:
            self.say(f"{what}: a uniform grid has one level, so there is nothing to do")
        return several

    def faster(self) -> None:
        self._pace(1)

    def slower(self) -> None:
        self._pace(-1)

    def _pace(self, change: int) -> None:
        rate = self.session.display.look.rate
        order = [r if r is not None else float("inf") for r in RATES]
        now = float("inf") if rate is None else rate
        if change > 0:
            new = min((r for r in order if r > now), default=order[-1])
        else:
            new = max((r for r in order if r < now), default=order[0])
        self.session.display.set(rate=None if new == float("inf") else new)
        self.say("pace: " + ("as fast as it goes" if new == float("inf") else f"{new:g} steps/s"))
        if self.session.busy == "run" and self.session.runs_freely:
            self.session.cancel()
            self.session.run()

    def reference(self) -> None:
        if self.session.exact is not None:
            self.say("the exact answer is there; views and overlay show it")
        self.session.reference.compute()

    def keep(self) -> None:
        kept = self.session.keep_run()
        if kept is None:
            self.say("there is no run to keep yet")
        else:
            self.say(f"kept {kept.label}; choose another method to compare")
