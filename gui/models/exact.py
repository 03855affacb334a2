"""Answers of methods that do not step, and the exact one among them."""

from __future__ import annotations

from flatland.field import Field
from flatland.scene import Scene
from gui.models.choice import Choice
from gui.models.helper import ask
from gui.models.jobs import Cancelled, Job, Watch
from studies.reference import Reference


class ExactSolver:
    """Answers "reference" jobs with the field that `studies` compares with."""

    def perform(self, job: Job, watch: Watch) -> Field:
        """The exact field at the bands of the job's method. Raises InputError, Cancelled."""
        field = ask(
            exact_field,
            job.scene,
            job.choice.bands,
            job.choice.bounces,
            wanted=lambda: not watch.cancelled(),
            tell=watch.notice,
        )
        if field is None:
            raise Cancelled
        assert isinstance(field, Field)
        return field


def exact_field(scene: Scene, bands: int, bounces: bool) -> Field:
    """The reference of the studies."""
    return Reference(scene, bounces=bounces).field(bands)


def answer(scene: Scene, choice: Choice) -> Field:
    """What a method that does not step says."""
    method = choice.method()
    return method.propagator.solve(scene, method.bands)
