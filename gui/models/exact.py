"""The exact answer of a scene, for a worker of its own."""

from __future__ import annotations

from flatland.field import Field
from gui.models.engine import Cancelled, Job, Watch
from studies.reference import Reference


class ExactSolver:
    """Answers "reference" jobs with the field that `studies` compares with."""

    def perform(self, job: Job, watch: Watch) -> Field:
        """The exact field at the bands of the job's method. Raises InputError, Cancelled."""
        field = Reference(job.scene, bounces=job.choice.bounces).field(job.choice.bands)
        if watch.cancelled():
            raise Cancelled
        return field
